// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace tallow {

/// Integral of f over [low, high] by the trapezoidal rule in ln x, with steps of at most `step`.
///
/// Domain   0 < low < high; x f(x) small at both ends. For analytic f the error then falls as
///          e^(-pi^2 / step): 5e-5 at 1, 3e-9 at 0.5, where f varies over a factor e of x or more.
template <class F>
double integrate_log(double low, double high, double step, F&& f) {
    const int n = static_cast<int>(std::ceil(std::log(high / low) / step));
    const double h = std::log(high / low) / n, ratio = std::exp(h);
    double x = low, sum = 0.5 * low * f(low);
    for (int i = 1; i < n; ++i) {
        x *= ratio;
        sum += x * f(x);
    }
    return h * (sum + 0.5 * high * f(high));
}

}  // namespace tallow
