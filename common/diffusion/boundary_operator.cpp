// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/boundary_operator.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/IterativeSolvers>

#include "common/base/parallel.h"

namespace tallow {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Clusters nearer than so many cluster sizes are integrated over their samples. Measured: see
// docs/BODY_AWARE.md.
constexpr float kNear = 3;

constexpr float kInv4Pi = float(1 / (4 * std::numbers::pi));

/// Integral over a piece of surface of vector area N, area a, at distance d from the point: its
/// part of k, of k with the decay, and of the single layer.
class PieceIntegral {
public:
    explicit PieceIntegral(const ChannelDiffusion& channel)
        : s_(float(channel.s)), single_(float(1 / (2 * channel.A * channel.D)) * kInv4Pi) {}

    /// Returns the coefficient of phi_j and adds that of phi_i to `diagonal`.
    float operator()(Vec3 d, Vec3 N, float a, float rho, float& diagonal) const {
        const float inverse = 1 / rho;
        const float k = kInv4Pi * glm::dot(N, d) * inverse * inverse * inverse;
        const float decay = std::exp(-s_ * rho);
        diagonal += k;
        return (single_ * a * inverse - k * (1 + s_ * rho)) * decay;
    }

private:
    float s_, single_;
};

float half_radius(float area) { return 0.5f * std::sqrt(area / std::numbers::pi_v<float>); }

}  // namespace

BoundaryOperator::BoundaryOperator(const SampledSurface& samples, const SurfaceClusters& clusters,
                                   const ChannelDiffusion& channel)
    : n_(clusters.count()), matrix_(n_ * n_) {
    const PieceIntegral integral(channel);
    const auto near = float(kNear * clusters.size);
    parallel_for(n_, 8, [&](std::size_t i) {
        const Vec3 x = clusters.position[i];
        float* row = matrix_.data() + i * n_;
        double diagonal = 0;
        for (std::size_t j = 0; j < n_; ++j) {
            const Vec3 d = clusters.centroid[j] - x;
            const float rho = glm::length(d);
            float k = 0;
            if (rho > near) {
                row[j] = integral(d, clusters.vector_area[j], clusters.area[j], rho, k);
            } else {
                float sum = 0;
                for (const std::uint32_t s : clusters.samples(j)) {
                    const Vec3 to = samples.position[s] - x;
                    const float a = samples.area[s];
                    sum += integral(to, a * samples.normal[s], a,
                                    std::max(glm::length(to), half_radius(a)), k);
                }
                row[j] = sum;
            }
            diagonal += double(k);
        }
        row[i] += float(diagonal);
    });
}

BoundaryOperator::Solution BoundaryOperator::solve(const std::vector<double>& source,
                                                   const std::vector<double>& guess,
                                                   double tolerance) const {
    const Eigen::Map<const Matrix> matrix(matrix_.data(), Eigen::Index(n_), Eigen::Index(n_));
    const Eigen::VectorXf b =
        Eigen::Map<const Eigen::VectorXd>(source.data(), Eigen::Index(n_)).cast<float>();
    Eigen::VectorXf x =
        Eigen::Map<const Eigen::VectorXd>(guess.data(), Eigen::Index(n_)).cast<float>();
    Solution solution;
    if (b.norm() == 0) return {std::vector<double>(n_), 0, true};
    Eigen::GMRES<Matrix, Eigen::IdentityPreconditioner> gmres(matrix);
    gmres.setMaxIterations(200);
    for (float residual = 1e-2f; residual > 1e-7f && !solution.converged; residual *= 0.1f) {
        gmres.setTolerance(residual);
        const Eigen::VectorXf next = gmres.solveWithGuess(b, x);
        solution.iterations += int(gmres.iterations());
        solution.converged = (next - x).norm() <= float(tolerance) * next.norm();
        x = next;
    }
    solution.phi.assign(x.data(), x.data() + n_);
    return solution;
}

}  // namespace tallow
