// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace tallow {

/// A spectral triple: linear red, green, blue. It does not convert to a position or a direction,
/// so that a normal can never be scaled per channel by accident.
struct Rgb {
    float r = 0, g = 0, b = 0;

    constexpr Rgb() = default;
    constexpr explicit Rgb(float grey) : r(grey), g(grey), b(grey) {}
    constexpr Rgb(float red, float green, float blue) : r(red), g(green), b(blue) {}

    constexpr float operator[](int channel) const {
        return channel == 0 ? r : channel == 1 ? g : b;
    }
    constexpr float& operator[](int channel) { return channel == 0 ? r : channel == 1 ? g : b; }

    constexpr Rgb& operator+=(Rgb o) { return *this = {r + o.r, g + o.g, b + o.b}; }
    constexpr Rgb& operator*=(Rgb o) { return *this = {r * o.r, g * o.g, b * o.b}; }
    constexpr Rgb& operator*=(float s) { return *this = {r * s, g * s, b * s}; }
    constexpr bool operator==(const Rgb&) const = default;
};

constexpr Rgb operator+(Rgb a, Rgb b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
constexpr Rgb operator-(Rgb a, Rgb b) { return {a.r - b.r, a.g - b.g, a.b - b.b}; }
constexpr Rgb operator*(Rgb a, Rgb b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
constexpr Rgb operator/(Rgb a, Rgb b) { return {a.r / b.r, a.g / b.g, a.b / b.b}; }
constexpr Rgb operator*(Rgb a, float s) { return {a.r * s, a.g * s, a.b * s}; }
constexpr Rgb operator*(float s, Rgb a) { return a * s; }
constexpr Rgb operator/(Rgb a, float s) { return {a.r / s, a.g / s, a.b / s}; }

/// Applies f to each channel.
template <class F>
constexpr Rgb map(Rgb a, F&& f) {
    return {f(a.r), f(a.g), f(a.b)};
}

constexpr float max_channel(Rgb a) { return std::max({a.r, a.g, a.b}); }
constexpr float min_channel(Rgb a) { return std::min({a.r, a.g, a.b}); }
constexpr float mean(Rgb a) { return (a.r + a.g + a.b) * (1.0f / 3.0f); }
inline bool is_finite(Rgb a) {
    return std::isfinite(a.r) && std::isfinite(a.g) && std::isfinite(a.b);
}

}  // namespace tallow
