// SPDX-License-Identifier: Apache-2.0
// Media, surfaces and wishes -> a spacing for each body, before any sample is made.
#include "precompute/choose_spacing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/available_memory.h"
#include "common/base/errors.h"
#include "precompute/sample_surface.h"

namespace tallow {
namespace {

// Peak memory of pass one for one sample: cell, sample, sort keys, tree; and for each light group
// irradiance and direction. Measured on the bunny with one group, as the growth of the peak from 1M
// to 5M samples: 92 bytes in all.
constexpr double kBytesPerSample = 80, kBytesPerGroup = 24;

// And with indirect light, for each group: what surfaces and what bodies send, and the trees that
// the exitance of the last round is summed over. Measured on the bunny with two groups, from 200k
// to 1M samples: 555 bytes a sample in all.
constexpr double kBytesPerGroupOfIndirect = 215;

// For one fragment while it is clustered: itself, its key, its place.
constexpr double kBytesPerFragment = 64;

// A count is wrong by about 1 %; this leaves room for it within the 5 % that are promised.
constexpr double kCloseEnough = 0.02, kPromised = 0.05;

float surface_extent(const Surface& surface) {
    if (std::holds_alternative<TriangleMesh>(surface)) {
        const Box box = bounding_box(surface);
        return glm::length(box.high - box.low);
    }
    if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
        float extent = 0;
        for (int i = 0; i < 3; ++i)
            extent = std::max(extent, 2 * glm::length(sphere->to_world.linear[i]));
        return extent;
    }
    if (const auto* plane = std::get_if<PlaneSurface>(&surface)) return 2 * plane->radius;
    return kInfinity;
}

class SpacingChooser {
public:
    SpacingChooser(const Scene& scene, const SceneGeometry& geometry,
                   std::span<const Treatment> treatment)
        : scene_(scene), geometry_(geometry) {
        for (std::uint32_t object = 0; object < scene.objects.size(); ++object)
            if (const SubsurfaceMaterial* material = subsurface(scene, object);
                material != nullptr && treatment[object] == Treatment::samples) {
                const float extent = surface_extent(geometry.surfaces[object]);
                bodies_.push_back(
                    {object, automatic_spacing(material->medium, scene.settings.tolerance, extent),
                     0});
            }
    }

    std::vector<BodySpacing> choose(const SamplingWish& wish) {
        if (bodies_.empty()) return bodies_;
        if (wish.samples) return scaled(factor_for(*wish.samples));
        std::vector<BodySpacing> chosen = bodies_;
        for (BodySpacing& body : chosen) body.spacing = wish.spacing.value_or(body.spacing);
        require_memory(chosen);
        return chosen;
    }

private:
    const Surface& surface(const BodySpacing& body) const {
        return geometry_.surfaces[body.object];
    }

    std::vector<BodySpacing> scaled(double factor) const {
        std::vector<BodySpacing> result = bodies_;
        for (BodySpacing& body : result) body.spacing = float(factor * double(body.spacing));
        require_memory(result);
        return result;
    }

    /// Also sets how many samples are expected.
    void require_memory(std::vector<BodySpacing>& bodies) const {
        double samples = 0, fragments = 0;
        for (BodySpacing& body : bodies) {
            const WorkEstimate work = estimate_work(surface(body), body.spacing);
            body.expected = work.samples;
            samples += work.samples;
            fragments = std::max(fragments, work.fragments);  // one body after the other
        }
        const double needed =
            memory_of_samples(samples, scene_.groups.size(), indirect_bounces(scene_) > 0) +
            fragments * kBytesPerFragment;
        const AvailableMemory available = available_memory();
        if (needed < 0.9 * available.bytes && samples < 4e9) return;
        const auto finest = std::ranges::min_element(bodies, {}, &BodySpacing::spacing);
        throw InputError(fmt::format(
            "{}: a spacing of {:.3g} mm takes about {:.3g} samples and {:.1f} GiB, more than the "
            "{:.1f} GiB that the {} leaves; give a larger --spacing, or fewer --points",
            scene_.objects[finest->object].where, finest->spacing, samples, needed / (1 << 30),
            available.bytes / (1 << 30), available.limit));
    }

    double count(double factor) const {
        double samples = 0;
        for (const BodySpacing& body : scaled(factor))
            samples += count_samples(surface(body), body.spacing);
        return samples;
    }

    /// The factor at which `wished` samples are counted. The number falls about with the square of
    /// the factor, so that the next guess is that of a square law; where that leaves the bracket of
    /// the guesses so far, their geometric mean.
    double factor_for(double wished) const {
        double area_number = 0;
        for (const BodySpacing& body : bodies_)
            area_number +=
                surface_area(surface(body)) / (double(body.spacing) * double(body.spacing));
        double factor = std::sqrt(area_number / wished), best = factor;
        double best_count = std::numeric_limits<double>::infinity();
        double low = 0, high = std::numeric_limits<double>::infinity();
        constexpr int kGuesses = 16;
        for (int i = 0; i < kGuesses; ++i) {
            const double number = count(factor);
            if (std::abs(number - wished) < std::abs(best_count - wished))
                best = factor, best_count = number;
            if (std::abs(number - wished) <= kCloseEnough * wished) break;
            (number > wished ? low : high) = factor;
            factor *= std::clamp(std::sqrt(number / wished), 0.1, 10.0);
            if (factor <= low || factor >= high) factor = std::sqrt(low * high);
        }
        if (std::abs(best_count - wished) <= std::max(kPromised * wished, 1.0)) return best;
        throw InputError(fmt::format(
            "{}: --points: expected a number of samples that this body can have, got {:.0f}; the "
            "nearest are about {:.0f}",
            scene_.objects[bodies_[0].object].where, wished, best_count));
    }

    const Scene& scene_;
    const SceneGeometry& geometry_;
    std::vector<BodySpacing> bodies_;  // with their automatic spacings
};

}  // namespace

float automatic_spacing(const Medium& medium, double tolerance, float extent) {
    // At zero tolerance as at 0.01 %: the sampling of a surface is never exact.
    const double scale = std::pow(std::max(tolerance, 1e-4) / 0.01, 0.6);
    return std::min(float(0.35 * scale * double(min_channel(medium.mean_free_path()))), extent / 5);
}

std::vector<BodySpacing> choose_spacings(const Scene& scene, const SceneGeometry& geometry,
                                         std::span<const Treatment> treatment,
                                         const SamplingWish& wish) {
    return SpacingChooser(scene, geometry, treatment).choose(wish);
}

double memory_of_samples(double samples, std::size_t groups, bool indirect) {
    const double of_group = kBytesPerGroup + (indirect ? kBytesPerGroupOfIndirect : 0);
    return samples * (kBytesPerSample + of_group * double(groups));
}

}  // namespace tallow
