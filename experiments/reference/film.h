// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace tallow::reference {

/// What happened to light between lamp and camera.
enum Layer : int {
    single,  ///< exactly one collision, the body met once from outside
    multi,   ///< two or more, the body met once from outside
    ext,     ///< scattered, and met a body from outside twice or more
    mirror   ///< no collision
};
inline constexpr int kLayers = 4;
inline constexpr int kChannels = 3;

/// `arrivals` counts the paths' straight pieces through the air that end at a body, seen from the
/// lamp, or that begin at one, seen from the camera: every path has the same number either way,
/// one less than its pieces through the air.
inline Layer layer_of(std::uint64_t collisions, std::uint32_t arrivals) {
    if (collisions == 0) return mirror;
    if (arrivals > 1) return ext;
    return collisions == 1 ? single : multi;
}

/// Radiance that a batch of walks brought to the pixels, W/(mm^2 sr).
class Film {
public:
    explicit Film(std::size_t pixels) : pixels_(pixels) {
        for (auto& values : values_) values.assign(pixels, 0.0f);
    }
    std::size_t pixels() const { return pixels_; }

    void add(Layer layer, int channel, std::uint32_t pixel, float radiance) {
        of(layer, channel)[pixel] += radiance;
    }
    std::vector<float>& of(int layer, int channel) {
        return values_[std::size_t(layer * kChannels + channel)];
    }
    const std::vector<float>& of(int layer, int channel) const {
        return values_[std::size_t(layer * kChannels + channel)];
    }

private:
    std::size_t pixels_;
    std::array<std::vector<float>, kLayers * kChannels> values_;
};

}  // namespace tallow::reference
