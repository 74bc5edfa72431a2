// SPDX-License-Identifier: Apache-2.0
// Picture -> cumulative table over the cells between its pixel centres. A draw inverts the row's
// and the cell's distribution and then that of the bilinear function inside the cell.
#include "common/scene/light_image.h"

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/check.h"

namespace tallow {
namespace {

float brightness(Rgb c) { return c.r / 3 + c.g / 3 + c.b / 3; }  // the sum may overflow

/// In [0, 1], with a density that runs linearly from a to b, at cumulative probability u: the root
/// of (b - a) x^2 / 2 + a x = u (a + b) / 2, in the form that does not cancel.
double draw_linear(double u, double a, double b) {
    const double root = std::sqrt(a * a + u * (b * b - a * a));
    return a + root > 0 ? std::min(1.0, u * (a + b) / (a + root)) : u;
}

/// The first entry above u; where in it u lies is left in `u`.
std::size_t find_and_rescale(const float* ends, std::size_t count, float& u) {
    const float* found = std::min(std::upper_bound(ends, ends + count, u), ends + count - 1);
    const float begin = found == ends ? 0 : found[-1];
    u = *found > begin ? std::clamp((u - begin) / (*found - begin), 0.0f, 1.0f) : 0.5f;
    return std::size_t(found - ends);
}

std::uint64_t hash_of(const RgbImage& image) {
    XXH3_state_t* state = XXH3_createState();
    XXH3_64bits_reset(state);
    const std::int32_t size[2] = {image.width, image.height};
    XXH3_64bits_update(state, size, sizeof size);
    XXH3_64bits_update(state, image.pixels.data(), image.pixels.size() * sizeof(Rgb));
    const std::uint64_t hash = XXH3_64bits_digest(state);
    XXH3_freeState(state);
    return hash;
}

}  // namespace

LightImage::LightImage(RgbImage image, Layout layout) : image_(std::move(image)), layout_(layout) {
    TALLOW_CHECK(image_.width > 0 && image_.height > 0 &&
                     image_.pixels.size() == std::size_t(image_.width) * std::size_t(image_.height),
                 "{} x {} image of {} pixels", image_.width, image_.height, image_.pixels.size());
    for (const Rgb& pixel : image_.pixels) brightest_ = std::max(brightest_, max_channel(pixel));
    hash_ = hash_of(image_);
    const double mean = mean_brightness();
    mean_ = float(mean);
    tabulate();
    // Rounding of a constant picture's mean is no excess.
    constexpr double kLeastShare = 1e-6;
    const double all = layout_ == Layout::flat ? mean : mean * 2 / std::numbers::pi;
    // Chosen: where the sun is hidden, half of the samples still see the rest of the sky, and where
    // it is not, half of them are plenty for something that small.
    constexpr double kMostShare = 0.5;
    share_ = total_ > kLeastShare * all ? float(std::min(kMostShare, total_ / all)) : 0.0f;
}

/// Of the interpolant, with the weight g.
double LightImage::mean_brightness() const {
    double sum = 0, weights = 0;
    for (int y = 0; y < image_.height; ++y) {
        double row = 0;
        for (int x = 0; x < image_.width; ++x) row += brightness(image_.at(x, y));
        // A pixel counts as half of the cells above and below it, and with all of those at an edge.
        const std::size_t above = std::size_t(y), below = above + 1;
        const double share_above = y == 0 ? 1 : 0.5, share_below = y + 1 == image_.height ? 1 : 0.5;
        const double weight =
            share_above * row_weight(above) * (node_v(above + 1) - node_v(above)) +
            share_below * row_weight(below) * (node_v(below + 1) - node_v(below));
        sum += weight * row / image_.width;
        weights += weight;
    }
    return sum / weights;
}

void LightImage::tabulate() {
    const std::size_t columns = std::size_t(image_.width) + 1,
                      rows = std::size_t(image_.height) + 1;
    std::vector<double> row_sum(rows), cell_sum(columns);
    cell_end_.resize(columns * rows);
    for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t column = 0; column < columns; ++column) {
            const double corners = double(node(column, row)) + node(column + 1, row) +
                                   node(column, row + 1) + node(column + 1, row + 1);
            row_sum[row] += corners / 4 * (node_u(column + 1) - node_u(column));
            cell_sum[column] = row_sum[row];
        }
        for (std::size_t column = 0; column < columns; ++column)
            cell_end_[row * columns + column] =
                row_sum[row] > 0 ? float(cell_sum[column] / row_sum[row]) : 1.0f;
        total_ += row_sum[row] * row_weight(row) * (node_v(row + 1) - node_v(row));
        row_sum[row] = total_;
    }
    for (const double sum : row_sum) row_end_.push_back(total_ > 0 ? float(sum / total_) : 1.0f);
}

float LightImage::node_u(std::size_t column) const {
    return std::clamp((float(column) - 0.5f) / float(image_.width), 0.0f, 1.0f);
}

float LightImage::node_v(std::size_t row) const {
    return std::clamp((float(row) - 0.5f) / float(image_.height), 0.0f, 1.0f);
}

float LightImage::row_weight(std::size_t row) const {
    if (layout_ == Layout::flat) return 1;
    // (cos a - cos b) / (b - a) without cancellation
    const float middle = kPi / 2 * (node_v(row) + node_v(row + 1));
    const float half = kPi / 2 * (node_v(row + 1) - node_v(row));
    return std::sin(middle) * (std::sin(half) / half);
}

float LightImage::excess_of(Rgb pixel) const { return std::max(0.0f, brightness(pixel) - mean_); }

float LightImage::excess(int x, int y) const { return excess_of(image_.at(x, y)); }

float LightImage::node(std::size_t column, std::size_t row) const {
    const int y = std::clamp(int(row) - 1, 0, image_.height - 1);
    const int last = image_.width - 1;
    if (layout_ == Layout::directions && (column == 0 || column > std::size_t(last) + 1))
        return 0.5f * (excess(0, y) + excess(last, y));  // the seam
    return excess(std::clamp(int(column) - 1, 0, last), y);
}

LightImage::Axis LightImage::across(float u) const {
    const float x = u * float(image_.width) - 0.5f;
    const int last = image_.width - 1;
    const int low = std::clamp(int(std::floor(x)), -1, last);
    const float fraction = std::clamp(x - float(low), 0.0f, 1.0f);
    if (layout_ == Layout::directions)
        return {low < 0 ? last : low, low == last ? 0 : low + 1, fraction};
    return {std::max(low, 0), std::min(low + 1, last), fraction};
}

LightImage::Axis LightImage::down(float v) const {
    const float y = v * float(image_.height) - 0.5f;
    const int last = image_.height - 1;
    const int low = std::clamp(int(std::floor(y)), -1, last);
    return {std::max(low, 0), std::min(low + 1, last), std::clamp(y - float(low), 0.0f, 1.0f)};
}

LightImage::Texel LightImage::at(Vec2 uv) const {
    const Axis x = across(uv.x), y = down(uv.y);
    Rgb color;
    float e = 0;
    const auto add = [&](float weight, int i, int j) {
        const Rgb pixel = image_.at(i, j);
        color += weight * pixel;
        e += weight * excess_of(pixel);
    };
    add((1 - x.fraction) * (1 - y.fraction), x.low, y.low);
    add(x.fraction * (1 - y.fraction), x.high, y.low);
    add((1 - x.fraction) * y.fraction, x.low, y.high);
    add(x.fraction * y.fraction, x.high, y.high);
    if (share_ == 0) return {color, 0};
    const int row =
        std::clamp(int(std::floor(uv.y * float(image_.height) + 0.5f)), 0, image_.height);
    return {color, float(e * (row_weight(std::size_t(row)) / total_))};
}

Vec2 LightImage::draw(Vec2 u) const {
    TALLOW_DCHECK(share_ > 0, "a picture that is nowhere brighter than its mean");
    const std::size_t columns = std::size_t(image_.width) + 1;
    const std::size_t row = find_and_rescale(row_end_.data(), row_end_.size(), u.y);
    const std::size_t column = find_and_rescale(&cell_end_[row * columns], columns, u.x);
    const double a = node(column, row), b = node(column + 1, row);
    const double c = node(column, row + 1), d = node(column + 1, row + 1);
    const double y = draw_linear(u.y, a + b, c + d);
    const double x = draw_linear(u.x, (1 - y) * a + y * c, (1 - y) * b + y * d);
    return {node_u(column) + float(x) * (node_u(column + 1) - node_u(column)),
            node_v(row) + float(y) * (node_v(row + 1) - node_v(row))};
}

}  // namespace tallow
