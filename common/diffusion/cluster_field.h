// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "common/base/rgb.h"
#include "common/diffusion/leaving_radiance.h"
#include "common/diffusion/surface_clusters.h"

namespace tallow {

/// Which clusters are near a point of the surface, and how much each counts there:
///
///     w_j = a_j e^(-|x - x_j|^2 / (2 h^2)) max(0, n . n_j)^2
///
/// with h near the clusters' size.
class ClusterNeighbours {
public:
    explicit ClusterNeighbours(const SurfaceClusters& clusters);

    /// Calls f(cluster, weight) for all that count at a point [mm] with its unit normal.
    template <class F>
    void visit(Vec3 position, Vec3 n, const F& f) const;

private:
    struct Item {
        Vec3 position, normal;
        float area;
        std::uint32_t cluster;
    };
    std::size_t cell_of(Vec3 position) const;
    int index(float x, int axis) const;

    float size_ = 0;  // of a cluster, mm
    Vec3 low_{0};
    int cells_[3] = {1, 1, 1};
    std::vector<std::uint32_t> first_;  // [cell + 1] into items_
    std::vector<Item> items_;           // cell by cell
};

/// The ratio of two fields that are known at the clusters of a surface, between them:
///
///     ratio(x, n) = sum of w_j B_j / sum of w_j H_j
///
/// Clamped to [kLeast, kMost], where the body's field is lost in the rounding of its largest
/// values.
class ClusterRatio {
public:
    static constexpr float kLeast = 0.02f, kMost = 50;

    /// B[cluster] and H[cluster] >= 0. `strength` is the share of the ratio's departure from 1 that
    /// counts.
    ClusterRatio(const SurfaceClusters& clusters, std::vector<Rgb> B, std::vector<Rgb> H,
                 Rgb strength = Rgb(1));

    /// At a point of the surface [mm] with its unit normal; 1 where nothing is known.
    Rgb at(Vec3 position, Vec3 n) const;

private:
    ClusterNeighbours neighbours_;
    std::vector<Rgb> B_, H_;  // [cluster]
    Rgb strength_;
};

/// Exitance by the body's diffusion in place of the half-space's, as a factor of a profile's sum P:
///
///     factor(x, w_o) = (X(w') + q rest) / P_c,   rest = P_{>= 2} - H
///
/// with all of them interpolated between clusters, X for the direction w' that refracts into w_o,
/// and such that pi L = F_t(w_o) / (2 * integral of F_t mu) M. Where both the factor is above 1 and
/// P above P_c, what is above P_c is added to P. What the half-space's diffusion misses of the
/// profile is added: light that scatters only twice or thrice, near where it entered. Of what
/// leaves after one scattering X has what the body has; the profile only tells how it is spread
/// between clusters. There is more of the rest where light enters and leaves at an angle: q is the
/// second order's part of that, in a half-space without an interface,
///
///     q = (f(mu_0) + f(mu)) / (mu_0 + mu) / (the same for what P is of),   f(mu) = mu ln(1 + 1 /
///     mu)
///
/// mu_0 and mu being the cosines inside of light that enters near x, in the mean, and of w'.
///
/// Source   docs/BODY_AWARE.md; f from Chandrasekhar's H function to first order in the albedo.
class LeavingField {
public:
    using ClusterRadiance = std::array<LeavingRadiance, 3>;

    /// What is known at the clusters: X; `rest`, P of two scatterings and more, less H; P; and the
    /// flux that enters, E, by itself and times its cosine inside; W/mm^2.
    struct AtClusters {
        std::span<const ClusterRadiance> radiance;
        std::span<const Rgb> rest, P, E, E_mu;
    };

    /// Without `directional` light leaves alike in all directions.
    LeavingField(const SurfaceClusters& clusters, const AtClusters& fields, float eta,
                 bool directional, Rgb strength);

    /// Of the profile's sum P [W/mm^2] at a point of the surface [mm] with its unit normal, towards
    /// w_o (unit, outside); 1 where nothing is known. Clamped as ClusterRatio is.
    Rgb factor(Vec3 position, Vec3 n, Vec3 w_o, Rgb P) const;

private:
    struct Item {
        Rgb even, rest, P, E, E_mu;
        std::array<Vec3, 3> slope;
    };
    ClusterNeighbours neighbours_;
    std::vector<Item> items_;  // [cluster]
    Rgb strength_;
    float eta_;
    bool directional_;
    float mean_cosine_;  // of w' with the normal, of all light that leaves evenly
};

}  // namespace tallow
