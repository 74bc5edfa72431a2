// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/evaluator/problem.h"

namespace tallow {

/// One way of computing the sums of a problem at one setting: times in seconds, the best of some
/// runs, and the results of the last.
struct Measurement {
    double grouping = 0, evaluation = 0;
    std::vector<double> runs;  // s, all evaluations
    // CPU seconds of the process per second of the fastest evaluation. Well below the number of
    // threads, something else had the cores, or the work was not shared.
    double busy = 0;
    double evaluations = 0;                      // of kernels, for each point, all channels
    std::array<std::vector<float>, 3> M, bound;  // [channel][point]; bounds may be empty
    std::size_t repeated = 0, uncertified = 0;   // of points and channels
};

/// A criterion: prepared once, then measured setting by setting.
class Method {
public:
    virtual ~Method() = default;
    virtual Measurement measure(double setting, int repeat) const = 0;
    double preparation() const { return preparation_; }
    std::string isa = "scalar", kernel = "table";

protected:
    double preparation_ = 0;
};

/// PointSum, the setting being evaluate()'s or certify()'s tolerance.
std::unique_ptr<Method> make_error_method(const Problem& problem, bool certified, int repeat);

/// The method of [JB02], SolidAngleSum, the setting being the solid angle: with our table, or with
/// the model's formula evaluated in float at each node, as published implementations do. Throws
/// UsageError if a formula is asked for and the model is not one of dipole.h.
std::unique_ptr<Method> make_solid_angle_method(const Problem& problem, bool formula, int repeat);

}  // namespace tallow
