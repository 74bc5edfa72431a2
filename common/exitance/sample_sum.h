// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/nbody/point_sum.h"
#include "common/nbody/solid_angle_sum.h"

namespace tallow {

/// How far the sum over the samples may be from the plain one.
struct ExitanceAccuracy {
    enum class Criterion {
        error,       ///< PointSum: nodes by the bound of their remainder
        solid_angle  ///< SolidAngleSum: the method of [JB02], for comparison
    };
    /// Accepted relRMSE of the hierarchy; 0 means the plain sum.
    float tolerance = 0.01f;
    Criterion criterion = Criterion::error;
    /// The tolerance is to hold for each point and channel, with proof.
    bool certified = false;
};

/// Points where sums are wanted; grouped once for all sums that share a unit.
class SumTargets {
public:
    SumTargets(std::vector<Vec3> positions, double unit, const ExitanceAccuracy& accuracy);

    std::span<const Vec3> positions() const { return positions_; }
    /// Only where the accuracy asks for sums by groups.
    const TargetGroups& groups() const { return *groups_; }

private:
    std::vector<Vec3> positions_;
    std::optional<TargetGroups> groups_;
};

/// One scalar sum over samples, taken in the way that an ExitanceAccuracy asks for.
class SampleSum {
public:
    /// Where samples are; one item a sample, in the order that `nodes` refers to.
    struct Samples {
        std::span<const Vec3> position;
        std::span<const float> area;
        std::span<const OctreeNode> nodes;
    };
    struct Result {
        std::vector<float> sum, evaluations;  // [target]
        std::vector<float> bound;             // [target] of the error; certified only
        PointSum::Certification certification;
    };

    SampleSum(const Samples& samples, std::span<const float> weights, KernelTable kernel,
              const ExitanceAccuracy& accuracy);

    /// Runs on all threads; the result does not depend on their number. `result` is overwritten.
    void evaluate(const SumTargets& targets, Result& result) const;

private:
    ExitanceAccuracy accuracy_;
    // One of these is made, as the accuracy asks for.
    std::unique_ptr<PointSum> by_error_;
    std::unique_ptr<SolidAngleSum> by_solid_angle_;
    std::optional<KernelTable> kernel_;  // for the solid angle; PointSum keeps its own
};

}  // namespace tallow
