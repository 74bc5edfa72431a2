// SPDX-License-Identifier: Apache-2.0
// Entry points and lights -> rays inside a body, over reflections -> power times length in cells.
#include "render/inner_light.h"

#include <algorithm>
#include <cmath>

#include "common/base/parallel.h"
#include "common/base/rng.h"
#include "common/lighting/cosine_direction.h"
#include "common/optics/fresnel.h"
#include "render/eye_path.h"
#include "render/light_collector.h"

namespace tallow {
namespace {

constexpr std::size_t kRays = 1 << 18;   // chosen: a quarter of a second of one core
constexpr std::size_t kPilot = 1 << 13;  // rays that measure the share first
constexpr std::size_t kChunk = 256;      // entry points that are followed together
constexpr int kMostReflections = 12;
constexpr float kLeastPower = 1e-3f;  // of what entered, below which a ray ends
constexpr int kMostCells = 160;       // along the longest side
constexpr float kCellOfPath = 0.5f;   // size of a cell in mean free paths

/// A piece of a ray's way.
struct Piece {
    Vec3 start, direction;
    float length;
    Rgb power;  // at its start, W; of a ray that measures volume A / 4 in mm^2
};

struct Traced {
    std::vector<Piece> reflected;  // after the first reflection
    std::vector<Piece> even;       // rays that cover the body evenly
    double first = 0, later = 0;   // power scattered before and after the first reflection
};

Rgb transmittance(Rgb sigma, float length) {
    Rgb result;
    for (int c = 0; c < 3; ++c) result[c] = std::exp(-sigma[c] * length);
    return result;
}

/// Rays from a chunk of entry points.
class Tracer {
public:
    Tracer(const ScatteringBody& body, const EntryPoints& entries)
        : body_(body), entries_(entries), sigma_t_(body.medium.sigma_t()) {}

    /// Entry points begin, begin + step, ... < end, with `rays` rays to each light.
    Traced trace(std::size_t begin, std::size_t end, std::size_t step, std::uint32_t rays) const {
        Traced traced;
        for (std::size_t i = begin; i < end; i += step)
            for (std::uint32_t k = 0; k < rays; ++k) {
                for (std::size_t l = 0; l < body_.scene.lights.size(); ++l)
                    enter(i, l, k, rays, traced);
                cross(i, k, rays, traced);
            }
        return traced;
    }

private:
    Vec2 sample(std::size_t entry, std::size_t use, std::uint32_t k) const {
        return sobol_2d(k, mix_bits(mix_bits(entry + 0x1a7e55ull) + use));
    }

    void enter(std::size_t i, std::size_t l, std::uint32_t k, std::uint32_t rays,
               Traced& traced) const {
        const Light& light = body_.scene.lights[l];
        const Rgb scale = body_.scene.groups[light.group].scale;
        if (light.off || max_channel(scale) == 0) return;
        const Vec3 x = entries_.positions[i], n = entries_.normals[i];
        const auto from = sample_light(light, x, n, sample(i, l + 1, k));
        if (!from) return;
        const float cos_i = glm::dot(from->w_i, n);
        if (cos_i <= 0) return;
        const auto w = refract(from->w_i, n, body_.medium.eta);
        if (!w || body_.rays.occluded(
                      {body_.rays.offset_origin(x, n, from->w_i), from->w_i, from->distance}))
            return;
        const float area = entries_.areas[i] / float(rays);
        const Rgb power = area * cos_i * fresnel_transmittance(body_.medium.eta, cos_i) *
                          from->radiance * scale * tint_at(body_, x, n);
        follow({x, *w, 0, power}, n, traced);
    }

    // Over all reflections.
    void follow(Piece piece, Vec3 n_g, Traced& traced) const {
        const float least = kLeastPower * max_channel(piece.power);
        for (int k = 0; k <= kMostReflections && max_channel(piece.power) > least; ++k) {
            const Vec3 start = body_.rays.offset_origin(piece.start, n_g, piece.direction);
            const auto end = body_.rays.intersect_object({start, piece.direction}, body_.object);
            if (!end) return;
            const auto reflection = reflect_inside(piece.direction, *end, body_.medium.eta);
            if (!reflection) return;
            piece.length = glm::length(end->position - piece.start);
            const Rgb left = piece.power * transmittance(sigma_t_, piece.length);
            (k == 0 ? traced.first : traced.later) +=
                double(mean((piece.power - left) * body_.medium.albedo()));
            if (k > 0) traced.reflected.push_back(piece);
            piece = {end->position, reflection->direction, 0, reflection->reflectance * left};
            n_g = end->n_g;
        }
    }

    void cross(std::size_t i, std::uint32_t k, std::uint32_t rays, Traced& traced) const {
        const Vec3 x = entries_.positions[i], n = entries_.normals[i];
        const Vec3 w = cosine_direction(-n, sample(i, 0, k));
        const auto end =
            body_.rays.intersect_object({body_.rays.offset_origin(x, n, w), w}, body_.object);
        if (end)
            traced.even.push_back({x, w, glm::length(end->position - x),
                                   Rgb(0.25f * entries_.areas[i] / float(rays))});
    }

    const ScatteringBody& body_;
    const EntryPoints& entries_;
    Rgb sigma_t_;
};

double share_of(const Traced& traced) {
    const double all = traced.first + traced.later;
    return all > 0 ? traced.later / all : 0;
}

}  // namespace

InnerLight::InnerLight(const ScatteringBody& body, const EntryPoints& entries, double least_share) {
    const std::size_t n = entries.positions.size();
    if (n == 0 || std::holds_alternative<PlaneSurface>(body.surface)) return;
    const Tracer tracer(body, entries);
    share_ = share_of(tracer.trace(0, n, std::max<std::size_t>(1, n / kPilot), 1));
    if (share_ < least_share) return;

    const auto rays = std::uint32_t(std::clamp<std::size_t>(kRays / n, 1, 256));
    const std::size_t step = std::max<std::size_t>(1, n / kRays);
    const std::size_t chunks = (n + kChunk - 1) / kChunk;
    std::vector<Traced> traced(chunks);
    parallel_for(chunks, 1, [&](std::size_t c) {
        traced[c] = tracer.trace(c * kChunk, std::min(n, (c + 1) * kChunk), step, rays);
    });
    lay_cells(body);
    const Rgb sigma_t = body.medium.sigma_t();
    // One after the other, so that sums do not depend on threads.
    const auto deposit = [&](const Piece& piece, auto&& add) {
        const int steps = std::max(1, int(std::ceil(2 * piece.length / size_)));
        const float ds = piece.length / float(steps);
        for (int k = 0; k < steps; ++k) {
            const float s = (float(k) + 0.5f) * ds;
            if (Cell* cell = cell_at(piece.start + s * piece.direction)) add(*cell, s, ds);
        }
    };
    for (const Traced& part : traced) {
        for (const Piece& piece : part.reflected)
            deposit(piece, [&](Cell& cell, float s, float ds) {
                cell.flux_length += ds * piece.power * transmittance(sigma_t, s);
            });
        for (const Piece& piece : part.even)
            deposit(piece, [&](Cell& cell, float, float ds) { cell.volume += ds * piece.power.r; });
    }
}

void InnerLight::lay_cells(const ScatteringBody& body) {
    const Box box = bounding_box(body.surface);
    const Vec3 extent = box.high - box.low;
    const float longest = std::max({extent.x, extent.y, extent.z});
    size_ = std::max(kCellOfPath / mean(body.medium.sigma_t()), longest / kMostCells);
    size_ = std::min(size_, longest / 2);
    origin_ = box.low - Vec3(0.5f * size_);
    for (int axis = 0; axis < 3; ++axis)
        count_[std::size_t(axis)] = int(std::ceil(extent[axis] / size_)) + 1;
    cells_.resize(index(0, 0, count_[2]));
}

InnerLight::Cell* InnerLight::cell_at(Vec3 p) {
    const Vec3 q = (p - origin_) / size_;
    const int x = int(std::floor(q.x)), y = int(std::floor(q.y)), z = int(std::floor(q.z));
    if (x < 0 || y < 0 || z < 0 || x >= count_[0] || y >= count_[1] || z >= count_[2])
        return nullptr;
    return &cells_[index(x, y, z)];
}

Rgb InnerLight::fluence(Vec3 x) const {
    const Vec3 q = (x - origin_) / size_ - Vec3(0.5f), floor = glm::floor(q), part = q - floor;
    Rgb flux_length;
    float volume = 0;
    for (int corner = 0; corner < 8; ++corner) {
        std::array<int, 3> at{};
        float weight = 1;
        bool outside = false;
        for (int axis = 0; axis < 3; ++axis) {
            const int up = corner >> axis & 1;
            at[std::size_t(axis)] = int(floor[axis]) + up;
            weight *= up == 1 ? part[axis] : 1 - part[axis];
            outside |=
                at[std::size_t(axis)] < 0 || at[std::size_t(axis)] >= count_[std::size_t(axis)];
        }
        if (outside) continue;
        const Cell& cell = cells_[index(at[0], at[1], at[2])];
        flux_length += weight * cell.flux_length;
        volume += weight * cell.volume;
    }
    return volume > 0 ? flux_length / volume : Rgb(0);
}

}  // namespace tallow
