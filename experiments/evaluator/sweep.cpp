// SPDX-License-Identifier: Apache-2.0
// Scene and cache -> error and time of the evaluator at a list of settings, as CSV on stdout.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/tool_main.h"
#include "experiments/evaluator/measure.h"
#include "experiments/evaluator/reference.h"

using namespace tallow;

namespace {

struct Arguments {
    std::filesystem::path scene, cache;
    std::string criterion = "error", accuracy, certify;
    std::vector<std::string> overrides;
    std::optional<int> samples, reference, repeat;
    std::optional<double> budget;
};

void declare(CommandLine& line, Arguments& a) {
    line.positional("SCENE", a.scene, "Scene file with one translucent body");
    line.positional("CACHE", a.cache, "Its cache, made by tallow-precompute");
    line.text("--criterion", a.criterion,
              "error: PointSum; solid-angle: SolidAngleSum with the table of the kernel; formula: "
              "the same with the dipole's formula at each node [default: error]",
              "error|solid-angle|formula");
    line.text("--accuracy", a.accuracy,
              "Settings: tolerances for error, solid angles (area / distance^2) for the others",
              "X,...");
    line.text("--certify", a.certify, "Tolerances to certify; with criterion error only", "X,...");
    line.integer("--samples", a.samples, 1, 65536, "an integer in [1, 65536]",
                 "Camera rays a pixel [default: 1]");
    line.integer("--reference", a.reference, 1, 1 << 30, "an integer > 0",
                 "Points where the plain sum is computed to compare with [default: 1000]");
    line.integer("--repeat", a.repeat, 1, 1000, "an integer > 0",
                 "Runs of which the fastest counts, of what takes below 10 s [default: 3]");
    line.number("--budget", a.budget, 0, 1e9, "a number of seconds > 0",
                "Skip settings that would take longer for one run, judged from the one before: "
                "time grows as 1/setting at most [default: never]");
    line.text_list("--set", a.overrides, "Override a value of the scene", "KEY=VALUE");
}

std::vector<double> parse_list(const std::string& name, const std::string& text) {
    std::vector<double> values;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        values.push_back(parse_number(name, text.substr(begin, end - begin), 1e-9, 100,
                                      "numbers in [1e-9, 100], separated by commas"));
        begin = end + 1;
    }
    return values;
}

std::string_view model_name(Model model) {
    return std::find_if(kModels.begin(), kModels.end(),
                        [&](const auto& named) { return named.second == model; })
        ->first;
}

/// bound / M over all points and channels with M > 0.
struct Tightness {
    double mean = 0, max = 0;
};

Tightness tightness(const Measurement& m) {
    Tightness result;
    double count = 0;
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < m.bound[c].size(); ++i) {
            if (m.M[c][i] <= 0) continue;
            const double ratio = double(m.bound[c][i]) / double(m.M[c][i]);
            result.mean += ratio, count += 1;
            result.max = std::max(result.max, ratio);
        }
    result.mean /= std::max(count, 1.0);
    return result;
}

constexpr const char* kHeader =
    "scene,material,model,lit_samples,points,criterion,kernel,setting,threads,isa,relRMSE,p99,max,"
    "grouping_s,evaluation_s,prepare_s,evaluations_per_point,mean_bound,max_bound,repeated_share,"
    "uncertified,violations,reference_points,busy,runs_s";

class Sweep {
public:
    Sweep(const Problem& problem, const Reference& reference, const Arguments& a, int threads)
        : problem_(problem), reference_(reference), arguments_(a), threads_(threads) {}

    void run(const std::string& criterion, const Method& method,
             const std::vector<double>& settings) const {
        double seconds = 0, before = 1;
        for (const double setting : settings) {
            if (arguments_.budget && seconds * before / setting > *arguments_.budget) continue;
            const Measurement m = method.measure(setting, arguments_.repeat.value_or(3));
            seconds = m.evaluation, before = setting;
            print(criterion, method, setting, m);
        }
    }

private:
    void print(const std::string& criterion, const Method& method, double setting,
               const Measurement& m) const {
        const Errors errors = compare(reference_, m.M, m.bound);
        fmt::print(
            "{},{},{},{},{},{},{},{:g},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.5g}",
            problem_.scene, problem_.material, model_name(problem_.kind.model),
            problem_.samples.position.size(), problem_.points.size(), criterion, method.kernel,
            setting, threads_, method.isa, errors.rel_rmse, errors.p99, errors.max, m.grouping,
            m.evaluation, method.preparation(), m.evaluations);
        if (m.bound[0].empty()) {
            fmt::print(",,,,,");
        } else {
            const Tightness tight = tightness(m);
            fmt::print(",{:.4g},{:.4g},{:.4g},{},{}", tight.mean, tight.max,
                       double(m.repeated) / (3 * double(problem_.points.size())), m.uncertified,
                       errors.outside);
        }
        fmt::print(",{},{:.3g},{:.4g}\n", reference_.point.size(), m.busy, fmt::join(m.runs, ";"));
        std::fflush(stdout);
    }

    const Problem& problem_;
    const Reference& reference_;
    const Arguments& arguments_;
    int threads_;
};

void sweep(const Arguments& a, ToolRun& run) {
    const std::vector<double> accuracy = parse_list("--accuracy", a.accuracy);
    const std::vector<double> certify = parse_list("--certify", a.certify);
    const bool by_error = a.criterion == "error", by_formula = a.criterion == "formula";
    if (!by_error && !by_formula && a.criterion != "solid-angle")
        throw UsageError(fmt::format(
            "--criterion: expected error, solid-angle or formula, got '{}'", a.criterion));
    if (!by_error && !certify.empty())
        throw UsageError(
            fmt::format("--certify: expected --criterion error, got {}, which has no "
                        "bound",
                        a.criterion));
    const Problem problem =
        load_problem(a.scene, a.cache, a.overrides, a.samples.value_or(1), run.stats);
    const Reference reference = compute_reference(problem, std::size_t(a.reference.value_or(1000)));
    const Sweep sweep(problem, reference, a, run.threads);
    const int repeat = a.repeat.value_or(3);
    fmt::print("{}\n", kHeader);
    if (!by_error) {
        sweep.run(a.criterion, *make_solid_angle_method(problem, by_formula, repeat), accuracy);
        return;
    }
    if (!accuracy.empty()) sweep.run("error", *make_error_method(problem, false, repeat), accuracy);
    if (!certify.empty())
        sweep.run("certified", *make_error_method(problem, true, repeat), certify);
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    return tool_main(
        "evaluator-sweep",
        "Measures error and time of the sums over samples, setting by setting, and prints CSV.",
        argc, argv, [&](CommandLine& line) { declare(line, arguments); },
        [&](ToolRun& run) { sweep(arguments, run); });
}
