// SPDX-License-Identifier: Apache-2.0
// Diffusion in a body against closed forms: a sphere, a slab, and the half-space.
#include "common/diffusion/body_diffusion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "common/cloud/morton.h"
#include "common/optics/diffusion.h"
#include "precompute/build_octree.h"

namespace tallow {
namespace {

/// A sampled closed surface and light that enters at right angles.
struct LitSurface {
    std::vector<Vec3> position, normal, w_i;
    std::vector<float> area;
    std::vector<Rgb> E_t;
    std::vector<OctreeNode> nodes;
    std::vector<Flight> flights;
    std::vector<std::uint32_t> index;

    void add(Vec3 x, Vec3 n, float a, float E) {
        position.push_back(x), normal.push_back(n), w_i.push_back(-n);
        area.push_back(a), E_t.push_back(Rgb(E));
    }
    void build_tree(float length = kInfinity) {
        const auto order = sorted_order(morton_codes(position));
        LitSurface sorted;
        for (const auto i : order) sorted.add(position[i], normal[i], area[i], E_t[i][0]);
        sorted.nodes = build_octree(sorted.position);
        for (std::uint32_t i = 0; i < position.size(); ++i) {
            sorted.flights.push_back({{Flight::Leg{sorted.w_i[i], length, 1}}});
            sorted.index.push_back(i);
        }
        *this = std::move(sorted);
    }
    SampledSurface surface() const { return {position, normal, area}; }
    EnteringLight light() const {
        return {position, normal, w_i, E_t, area, flights, index, nodes};
    }
};

constexpr ClusterWish k1000{1000, 1000};

// No surface within reach.
const FollowFlights kStraight = [](auto, auto, std::span<const Vec3> w, float) {
    std::vector<Flight> flights;
    for (const Vec3& direction : w) flights.push_back(Flight::straight(direction));
    return flights;
};

BodyDiffusion diffusion_in(const LitSurface& body, const Medium& medium) {
    return {body.surface(), medium, k1000, kStraight};
}

constexpr double kRadius = 10;

// E = 1 + cos theta, theta from +z.
LitSurface lit_sphere(int n) {
    LitSurface sphere;
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    for (int i = 0; i < n; ++i) {
        const double z = 1 - (2 * i + 1.0) / n, r = std::sqrt(1 - z * z);
        const Vec3 direction(r * std::cos(golden * i), r * std::sin(golden * i), z);
        sphere.add(float(kRadius) * direction, direction,
                   float(4 * std::numbers::pi * kRadius * kRadius / n), float(1 + z));
    }
    sphere.build_tree();
    return sphere;
}

// A plate of 60 x 60 mm, `thickness` thick, lit evenly from above (+z).
LitSurface lit_plate(double thickness, double step) {
    constexpr double kHalf = 30;
    LitSurface plate;
    const int n = int(2 * kHalf / step), m = std::max(1, int(thickness / step));
    const double h = 2 * kHalf / n, v = thickness / m;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double x = (i + 0.5) * h - kHalf, y = (j + 0.5) * h - kHalf;
            plate.add({x, y, 0}, {0, 0, 1}, float(h * h), 1);
            plate.add({x, y, -thickness}, {0, 0, -1}, float(h * h), 0);
        }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j)
            for (const double side : {-1.0, 1.0}) {
                const double x = (i + 0.5) * h - kHalf, z = -(j + 0.5) * v;
                plate.add({side * kHalf, x, z}, {side, 0, 0}, float(h * v), 0);
                plate.add({x, side * kHalf, z}, {0, side, 0}, float(h * v), 0);
            }
    plate.build_tree(float(thickness));
    return plate;
}

Medium medium(float sigma_a) { return {Rgb(sigma_a), Rgb(1), 0, 1.5f}; }

struct Constants {
    double D, s, A, alpha_prime, length;
};
Constants constants(const Medium& medium) {
    const ReducedChannel reduced = reduced_channel(medium, 0);
    const DiffusionConstants k = diffusion_constants(reduced.absorption, reduced.eta);
    const double mfp = 1 / reduced.sigma_t_prime;
    return {k.D * mfp, k.s / mfp, k.A, reduced.alpha_prime, mfp};
}

struct Depth {
    double z, weight;  // mm, 1
};
// The depths of first scattering that BodyDiffusion uses, on ways of this length [mm].
std::vector<Depth> source_depths(const Constants& k, float length = kInfinity) {
    const auto rule = first_scattering_rule(k.s * k.length);
    const Flight flight{{Flight::Leg{Vec3(0, 0, 1), length, 1}}};
    const Collisions collisions(flight, k.length);
    std::vector<Depth> depths;
    for (std::size_t i = 0; i < rule.weight.size(); ++i)
        depths.push_back({double(collisions.at(rule.share_on(i, collisions.length())).z),
                          rule.weight[i] * collisions.probability()});
    return depths;
}

using Function = std::function<double(double)>;
double derivative(const Function& f, double x) {
    const double h = 1e-5;
    return (f(x + h) - f(x - h)) / (2 * h);
}

/// The solutions of order l = 0 or 1 in a sphere: one that is regular at its center, and one that
/// meets the boundary condition.
class SphereSolutions {
public:
    SphereSolutions(const Constants& k, int l) : k_(k), l_(l) {
        const auto boundary = [&](const Function& f) {
            return f(kRadius) + 2 * k.A * k.D * derivative(f, kRadius);
        };
        mix_ = -boundary([&](double r) { return decaying(r); }) /
               boundary([&](double r) { return regular(r); });
    }
    double regular(double r) const {
        const double x = k_.s * r;
        return l_ == 0 ? std::sinh(x) / x : (x * std::cosh(x) - std::sinh(x)) / (x * x);
    }
    double outer(double r) const { return decaying(r) + mix_ * regular(r); }
    /// Fluence of sources q a^-2 Y on the shell of radius a, over regular(r) inside of it and over
    /// outer(r) outside.
    double inside(double a, double q) const { return q / (a * a * k_.D) * outer(a) / wronskian(a); }
    double outside(double a, double q) const {
        return q / (a * a * k_.D) * regular(a) / wronskian(a);
    }

private:
    double decaying(double r) const {
        const double x = k_.s * r;
        return l_ == 0 ? std::exp(-x) / x : std::exp(-x) * (1 + 1 / x) / x;
    }
    double wronskian(double a) const {
        const Function f = [&](double r) { return regular(r); },
                       g = [&](double r) { return outer(r); };
        return derivative(f, a) * outer(a) - regular(a) * derivative(g, a);
    }

    Constants k_;
    int l_;
    double mix_;
};

// Exitance of a sphere whose irradiance is the Legendre polynomial of order l = 0 or 1, at its
// pole.
double sphere_exitance(const Constants& k, int l) {
    const SphereSolutions solutions(k, l);
    double phi = 0;
    for (const auto& [z, w] : source_depths(k))
        phi += solutions.outside(kRadius - z, k.alpha_prime * w * kRadius * kRadius) *
               solutions.outer(kRadius);
    return phi / (2 * k.A);
}

TEST(BodyDiffusion, SphereMatchesItsClosedForm) {
    const LitSurface sphere = lit_sphere(20000);
    for (const float sigma_a : {0.0003f, 0.01f, 0.3f}) {
        const BodyDiffusion diffusion = diffusion_in(sphere, medium(sigma_a));
        const auto solution = diffusion.solve(sphere.light());
        EXPECT_TRUE(solution.converged);
        const Constants k = constants(medium(sigma_a));
        const double even = sphere_exitance(k, 0), odd = sphere_exitance(k, 1);
        double square = 0;
        for (std::size_t i = 0; i < solution.fine.B.size(); ++i) {
            const double z = double(diffusion.clusters().position[i].z) / kRadius;
            const double error = double(solution.fine.B[i][0]) - (even + odd * z);
            square += error * error;
        }
        const double rms = std::sqrt(square / double(solution.fine.B.size())) / even;
        EXPECT_LT(rms, 0.01) << "sigma_a " << sigma_a;
    }
}

TEST(BodyDiffusion, SlabMatchesItsClosedForm) {
    for (const double thickness : {1.5, 6.0})
        for (const float sigma_a : {0.05f}) {
            const LitSurface plate = lit_plate(thickness, 0.5);
            const BodyDiffusion diffusion = diffusion_in(plate, medium(sigma_a));
            const auto solution = diffusion.solve(plate.light());
            const Constants k = constants(medium(sigma_a));
            const auto u = [&](double x) {
                return std::sinh(k.s * x) + 2 * k.A * k.D * k.s * std::cosh(k.s * x);
            };
            double front = 0, back = 0;
            for (const auto& [z, w] : source_depths(k, float(thickness))) {
                const double W =
                    k.s * (u(z) * (std::cosh(k.s * (thickness - z)) +
                                   2 * k.A * k.D * k.s * std::sinh(k.s * (thickness - z))) +
                           u(thickness - z) *
                               (std::cosh(k.s * z) + 2 * k.A * k.D * k.s * std::sinh(k.s * z)));
                front += k.alpha_prime * w * u(0) * u(thickness - z) / (k.D * W * 2 * k.A);
                back += k.alpha_prime * w * u(z) * u(0) / (k.D * W * 2 * k.A);
            }
            double sum[2] = {}, count[2] = {};
            for (std::size_t i = 0; i < solution.fine.B.size(); ++i) {
                const Vec3 x = diffusion.clusters().position[i];
                if (std::abs(x.x) > 5 || std::abs(x.y) > 5) continue;
                const int side = x.z < -0.5 * thickness;
                sum[side] += double(solution.fine.B[i][0]), count[side] += 1;
            }
            EXPECT_NEAR(sum[0] / count[0], front, 0.02 * front) << thickness << " " << sigma_a;
            EXPECT_NEAR(sum[1] / count[1], back, 0.02 * back) << thickness << " " << sigma_a;
        }
}

TEST(BodyDiffusion, ThickBlockIsAHalfSpaceInItsMiddle) {
    const LitSurface block = lit_plate(20, 0.3);
    const BodyDiffusion diffusion = diffusion_in(block, medium(0.3f));
    const auto solution = diffusion.solve(block.light());
    // A profile that is what diffusion gives: nothing is to be put right.
    const std::vector<Rgb>& P = solution.fine.H;
    const LeavingField field(diffusion.clusters(),
                             {solution.radiance, std::vector<Rgb>(P.size(), Rgb(0)), P,
                              solution.entry.E, solution.entry.E_mu},
                             1.5f, false, Rgb(1));
    for (std::size_t i = 0; i < solution.fine.B.size(); ++i) {
        const Vec3 x = diffusion.clusters().position[i], n = diffusion.clusters().normal[i];
        if (std::abs(x.x) > 15 || std::abs(x.y) > 15 || x.z < -1) continue;
        EXPECT_NEAR(field.factor(x, n, n, P[i])[0], 1, 0.025);  // measured 0.0212
    }
}

std::vector<LeavingField::ClusterRadiance> even_radiance(std::size_t clusters, float X) {
    const LeavingRadiance even{X, Vec3(0)};
    return std::vector<LeavingField::ClusterRadiance>(clusters, {even, even, even});
}

// Twice as much light as the profile has around: a place where the profile has ten times as much
// gets no more of it than its neighbours do, one where it has less is multiplied.
TEST(LeavingField, BrightPlacesAreNotMultiplied) {
    const LitSurface block = lit_plate(4, 0.5);
    const BodyDiffusion diffusion = diffusion_in(block, medium(0.3f));
    const std::size_t n = diffusion.clusters().count();
    const auto radiance = even_radiance(n, 2);
    const std::vector<Rgb> ones(n, Rgb(1)), none(n, Rgb(0));
    const LeavingField field(diffusion.clusters(), {radiance, none, ones, none, none}, 1.5f, false,
                             Rgb(1));
    const Vec3 x = diffusion.clusters().position[n / 2],
               normal = diffusion.clusters().normal[n / 2];
    EXPECT_NEAR(field.factor(x, normal, normal, Rgb(0.1f))[0], 2, 1e-5);
    EXPECT_NEAR(field.factor(x, normal, normal, Rgb(1))[0], 2, 1e-5);
    EXPECT_NEAR(10 * field.factor(x, normal, normal, Rgb(10))[0], 11, 1e-4);
}

// More light that scattered twice leaves where light enters at an angle, and to where it leaves so:
// the profile's excess over diffusion is multiplied, and nothing else.
TEST(LeavingField, ObliqueLightScattersTwiceMoreOften) {
    const LitSurface block = lit_plate(4, 0.5);
    const BodyDiffusion diffusion = diffusion_in(block, medium(0.3f));
    const std::size_t n = diffusion.clusters().count();
    const auto radiance = even_radiance(n, 1);
    const std::vector<Rgb> P(n, Rgb(1.5f)), rest(n, Rgb(0.5f));
    const Vec3 x = diffusion.clusters().position[n / 2],
               normal = diffusion.clusters().normal[n / 2];
    const auto factor = [&](float mu_0) {
        const std::vector<Rgb> E(n, Rgb(2)), E_mu(n, Rgb(2 * mu_0));
        const LeavingField field(diffusion.clusters(), {radiance, rest, P, E, E_mu}, 1.5f, false,
                                 Rgb(1));
        return double(field.factor(x, normal, normal, Rgb(1.5f))[0]);
    };
    EXPECT_NEAR(factor(1), 1, 1e-5);
    const double mu = double(mean_cosine_of_leaving(1.5f)), mu_0 = 0.75;
    const auto f = [](double c) { return c * std::log(1 + 1 / c); };
    const double q = (f(mu_0) + f(mu)) / (mu_0 + mu) / ((f(1) + f(mu)) / (1 + mu));
    EXPECT_GT(q, 1.1);
    EXPECT_NEAR(factor(0.75f), (1 + 0.5 * q) / 1.5, 1e-5);
}

// The fluence inside of a sphere that is lit evenly, from that on its surface: at any place that is
// nearer to the center than all sources.
TEST(BoundaryOperator, KnowsTheFluenceInside) {
    const LitSurface sphere = lit_sphere(20000);
    for (const float sigma_a : {0.0003f, 0.01f, 0.3f}) {
        const Constants k = constants(medium(sigma_a));
        const double largest = largest_cluster_area(4 * std::numbers::pi * kRadius * kRadius, 1000);
        const PatchTree tree = build_patch_tree(sphere.surface(), largest);
        const SurfaceClusters clusters = cut_clusters(sphere.surface(), tree, largest);
        const ChannelDiffusion channel{k.D, k.s, k.A};
        const BoundaryOperator equation(sphere.surface(), tree, clusters,
                                        {channel, channel, channel});
        const std::vector<float> phi(clusters.count(), float(2 * k.A * sphere_exitance(k, 0)));
        PointPacket points{};
        std::array<double, PointPacket::kSize> radius{};
        for (int i = 0; i < PointPacket::kSize; ++i) {
            radius[std::size_t(i)] = (i + 0.5) / PointPacket::kSize * 0.7 * kRadius;
            const float angle = float(i);
            points.set(i,
                       float(radius[std::size_t(i)]) *
                           Vec3(std::cos(angle), std::sin(angle) * 0.6f, std::sin(angle) * 0.8f));
        }
        const SurfaceSum sum =
            equation.sum_layers(sphere.surface(), tree, 1, phi, std::span(&points, 1))[0];
        for (std::size_t i = 0; i < radius.size(); ++i) {
            const double x = k.s * radius[i];
            double S = 0, at_center = 0;
            for (const auto& [z, w] : source_depths(k)) {
                const double a = kRadius - z, q = k.alpha_prime * w * kRadius * kRadius;
                S += q / k.D * std::exp(-k.s * a) / a * std::sinh(x) / x;
                at_center += SphereSolutions(k, 0).inside(a, q);
            }
            const double expected = at_center * std::sinh(x) / x;  // regular(0) is 1
            EXPECT_NEAR(sum.solid_angle.of[i], 1, 0.01);
            EXPECT_NEAR(S - double(sum.layers.of[i]), expected, 0.01 * expected)
                << "sigma_a " << sigma_a << " r " << radius[i];
        }
    }
}

TEST(SurfaceClusters, PartitionTheSamplesAndDoNotReachThroughThinSheets) {
    const LitSurface plate = lit_plate(0.5, 0.5);
    const double largest = largest_cluster_area(2 * 60 * 60 + 4 * 60 * 0.5, 500);
    const PatchTree tree = build_patch_tree(plate.surface(), largest);
    const SurfaceClusters clusters = cut_clusters(plate.surface(), tree, largest);
    EXPECT_GE(clusters.count(), 500u);
    EXPECT_LE(clusters.count(), 1024u);
    std::vector<int> seen(plate.position.size());
    double area = 0;
    for (std::size_t i = 0; i < clusters.count(); ++i) {
        area += double(clusters.area[i]);
        for (const auto s : tree.samples(tree.patches[clusters.patch[i]])) {
            ++seen[s];
            EXPECT_GT(glm::dot(plate.normal[s], clusters.normal[i]), 0.5f);
        }
    }
    for (const int count : seen) EXPECT_EQ(count, 1);
    EXPECT_NEAR(area, 2 * 60 * 60 + 4 * 60 * 0.5, 0.5);
}

}  // namespace
}  // namespace tallow
