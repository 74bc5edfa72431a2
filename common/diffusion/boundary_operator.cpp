// SPDX-License-Identifier: Apache-2.0
// Clusters -> rows of the operator, 16 at a time, and GMRES with them.
#include "common/diffusion/boundary_operator.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/IterativeSolvers>

#include "common/base/check.h"
#include "common/base/parallel.h"

namespace tallow {
class ChannelMatrix;
}  // namespace tallow

namespace Eigen::internal {
template <>
struct traits<tallow::ChannelMatrix> : traits<SparseMatrix<float>> {};
}  // namespace Eigen::internal

namespace tallow {

/// One channel of the operator, as Eigen's solvers want a matrix.
class ChannelMatrix : public Eigen::EigenBase<ChannelMatrix> {
public:
    using Scalar = float;
    using RealScalar = float;
    using StorageIndex = int;
    enum {
        ColsAtCompileTime = Eigen::Dynamic,
        MaxColsAtCompileTime = Eigen::Dynamic,
        IsRowMajor = false
    };

    ChannelMatrix(const BoundaryOperator& rows, int channel, Eigen::Index n)
        : rows_(rows), channel_(channel), n_(n) {}

    Eigen::Index rows() const { return n_; }
    Eigen::Index cols() const { return n_; }

    template <class Vector>
    Eigen::Product<ChannelMatrix, Vector, Eigen::AliasFreeProduct> operator*(
        const Eigen::MatrixBase<Vector>& x) const {
        return {*this, x.derived()};
    }

    Eigen::VectorXf times(const Eigen::VectorXf& x) const {
        Eigen::VectorXf result(n_);
        rows_.multiply(channel_, {x.data(), std::size_t(n_)}, {result.data(), std::size_t(n_)});
        return result;
    }

private:
    const BoundaryOperator& rows_;
    int channel_;
    Eigen::Index n_;
};

namespace {

constexpr float kInv4Pi = float(1 / (4 * std::numbers::pi));

constexpr int kMostIterations = 200;  // of each step

// What GMRES makes of the residual of its guess, in the first step and in those that see whether
// the solution still changes.
constexpr float kFirstStep = 1e-2f, kNextSteps = 1e-1f;
constexpr int kMostSteps = 6;

}  // namespace
}  // namespace tallow

namespace Eigen::internal {
template <class Vector>
struct generic_product_impl<tallow::ChannelMatrix, Vector, SparseShape, DenseShape, GemvProduct>
    : generic_product_impl_base<tallow::ChannelMatrix, Vector,
                                generic_product_impl<tallow::ChannelMatrix, Vector>> {
    template <class Result>
    static void scaleAndAddTo(Result& result, const tallow::ChannelMatrix& matrix, const Vector& x,
                              float factor) {
        result += factor * matrix.times(x);
    }
};
}  // namespace Eigen::internal

namespace tallow {

BoundaryOperator::BoundaryOperator(const SampledSurface& samples, const PatchTree& tree,
                                   const SurfaceClusters& clusters,
                                   const std::array<ChannelDiffusion, 3>& channels) {
    for (std::size_t c = 0; c < 3; ++c) {
        s_[c] = float(channels[c].s);
        single_layer_[c] = kInv4Pi * float(1 / (2 * channels[c].A * channels[c].D));
    }
    cluster_of_.assign(tree.patches.size(), SurfacePatch::kNone);
    for (std::uint32_t i = 0; i < clusters.count(); ++i) {
        cluster_of_[clusters.patch[i]] = i;
        clusters_.push_back(tree.patches[clusters.patch[i]]);
    }
    if (clusters_.empty()) return;
    number_parents(tree);

    const BoundarySurface surface{samples, tree, cluster_of_, s_, single_layer_};
    constexpr std::size_t kSize = BoundaryPacket::kSize;
    packets_.resize((clusters_.size() + kSize - 1) / kSize);
    parallel_for(packets_.size(), 1, [&](std::size_t p) {
        BoundaryPacket& packet = packets_[p];
        packet.first = std::uint32_t(p * kSize);
        packet.count = std::uint32_t(std::min(kSize, clusters_.size() - p * kSize));
        for (std::uint32_t k = 0; k < kSize; ++k) {
            const std::uint32_t i = packet.first + std::min(k, packet.count - 1);
            packet.set(int(k), clusters.position[i]);
        }
        boundary_sum_functions().fill(surface, packet);
        for (BoundaryPacket::Far& far : packet.far) far.patch = parent_of_[far.patch];
    });
}

void BoundaryOperator::number_parents(const PatchTree& tree) {
    std::vector<std::uint32_t> parents;
    parent_of_.assign(tree.patches.size(), SurfacePatch::kNone);
    if (cluster_of_[0] == SurfacePatch::kNone) parents.push_back(0);
    for (std::size_t p = 0; p < parents.size(); ++p) {
        const SurfacePatch& patch = tree.patches[parents[p]];
        parent_of_[parents[p]] = std::uint32_t(p);
        Parent parent{patch.centroid, {}, {}};
        for (std::uint32_t h = 0; h < 2; ++h) {
            const std::uint32_t half = patch.child + h;
            parent.is_cluster[h] = cluster_of_[half] != SurfacePatch::kNone;
            parent.half[h] =
                parent.is_cluster[h] ? cluster_of_[half] : std::uint32_t(parents.size());
            if (!parent.is_cluster[h]) parents.push_back(half);
        }
        parents_.push_back(parent);
    }
}

void BoundaryOperator::lift(int channel, std::span<const float> phi,
                            std::vector<FluencePatch>& patches) const {
    const float single = single_layer_[std::size_t(channel)];
    const auto of_cluster = [&](std::uint32_t i) {
        const SurfacePatch& patch = clusters_[i];
        FluencePatch result{patch.centroid, single * patch.area * phi[i],
                            kInv4Pi * phi[i] * patch.vector_area,
                            0.5f * single * phi[i] * patch.second};
        result.M += kInv4Pi * phi[i] * patch.vector_first;
        return result;
    };
    patches.resize(parents_.size());
    for (std::size_t p = parents_.size(); p-- > 0;) {
        const Parent& parent = parents_[p];
        FluencePatch& sum = patches[p] = {parent.centroid, 0, Vec3(0), {}};
        for (std::size_t h = 0; h < 2; ++h) {
            const FluencePatch part =
                parent.is_cluster[h] ? of_cluster(parent.half[h]) : patches[parent.half[h]];
            const Vec3 d = part.center - parent.centroid;
            sum.Q += part.Q;
            sum.V += part.V + part.Q * d;
            sum.M += part.M;
            sum.M += symmetric_product(part.V + 0.5f * part.Q * d, d);
        }
    }
}

void BoundaryOperator::multiply(int channel, std::span<const float> phi,
                                std::span<float> result) const {
    std::vector<FluencePatch> patches;
    lift(channel, phi, patches);
    parallel_for(packets_.size(), 4, [&](std::size_t p) {
        BoundaryPacket::Lanes rows;
        boundary_sum_functions().multiply(packets_[p], channel, s_[std::size_t(channel)], patches,
                                          phi, rows);
        std::copy_n(rows.of, packets_[p].count, result.begin() + packets_[p].first);
    });
}

std::vector<SurfaceSum> BoundaryOperator::sum_layers(const SampledSurface& samples,
                                                     const PatchTree& tree, int channel,
                                                     std::span<const float> phi,
                                                     std::span<const PointPacket> points) const {
    std::vector<FluencePatch> patches;
    lift(channel, phi, patches);
    const BoundarySurface surface{samples, tree, cluster_of_, s_, single_layer_};
    const SurfaceFluence fluence{channel, phi, patches, parent_of_};
    std::vector<SurfaceSum> sums(points.size());
    parallel_for(points.size(), 4, [&](std::size_t p) {
        boundary_sum_functions().sum_layers(surface, fluence, points[p], sums[p]);
    });
    return sums;
}

BoundaryOperator::Solution BoundaryOperator::solve(int channel, const std::vector<double>& source,
                                                   const std::vector<double>& guess,
                                                   double tolerance) const {
    const auto n = Eigen::Index(clusters_.size());
    const ChannelMatrix matrix(*this, channel, n);
    // Of the source's own size: squares of light in tiny units would underflow.
    const Eigen::Map<const Eigen::VectorXd> S(source.data(), n), first(guess.data(), n);
    const double size = n > 0 ? S.lpNorm<Eigen::Infinity>() : 0;
    Solution solution;
    if (!(size > 0)) return {std::vector<double>(std::size_t(n)), 0, true};
    const Eigen::VectorXf b = (S / size).cast<float>();
    Eigen::VectorXf x = (first / size).cast<float>();
    Eigen::GMRES<ChannelMatrix, Eigen::IdentityPreconditioner> gmres(matrix);
    gmres.setMaxIterations(kMostIterations);
    gmres.set_restart(kMostIterations);
    for (int step = 0; step < kMostSteps && !solution.converged; ++step) {
        gmres.setTolerance(step == 0 ? kFirstStep : kNextSteps);  // of the guess's residual
        const Eigen::VectorXf next = gmres.solveWithGuess(b, x);
        solution.iterations += int(gmres.iterations());
        solution.converged = (next - x).norm() <= float(tolerance) * next.norm();
        x = next;
    }
    solution.phi.resize(std::size_t(n));
    Eigen::Map<Eigen::VectorXd>(solution.phi.data(), n) = size * x.cast<double>();
    return solution;
}

std::size_t BoundaryOperator::memory_bytes() const {
    std::size_t bytes = clusters_.size() * sizeof(SurfacePatch) + parents_.size() * sizeof(Parent);
    for (const BoundaryPacket& packet : packets_)
        bytes += sizeof packet +
                 packet.near.size() * (sizeof(std::uint32_t) + 3 * sizeof(BoundaryPacket::Lanes)) +
                 packet.far.size() * sizeof(BoundaryPacket::Far);
    return bytes;
}

}  // namespace tallow
