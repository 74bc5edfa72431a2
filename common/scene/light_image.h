// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/vec.h"
#include "common/image/read_image.h"

namespace tallow {

/// A picture that shines: its bilinear interpolant over the unit square, u across from the left and
/// v down from the top, and a table that draws points where it is brighter than its mean.
///
/// Pixels are known at their centres, the edges repeat the outermost ones. Brightness b is the mean
/// of the channels. The table's density over the square is, between each four pixel centres,
///
///     density(u, v) = e(u, v) g(v) / integral of e g,    e = interpolant of max(0, b - mean of b)
///
/// with g = 1, or, for a picture of all directions, g(v) = the mean of sin(pi v) over that row of
/// cells, so that dim and even parts are left to whatever other density the caller mixes with
/// share(). Points (u, v) of equal area become regions of equal probability that are connected and
/// in the same order, row by row: stratified points stay so.
///
/// Source   the subtraction of the mean: Karlik, Sik, Vevoda, Skrivan, Krivanek 2019, "MIS
///          Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", here
///          for one sample that is drawn from the table with probability share().
class LightImage {
public:
    enum class Layout {
        flat,       ///< a rectangle
        directions  ///< latitudes and longitudes: left and right edge meet, v is the angle from +y
    };

    /// Pixels as read_image() promises them.
    LightImage(RgbImage image, Layout layout);

    struct Texel {
        Rgb color;
        float density;  ///< of draw(), over the unit square
    };
    Texel at(Vec2 uv) const;

    /// A point with density at(point).density. `u` in [0, 1)^2. Only if share() > 0.
    Vec2 draw(Vec2 u) const;

    /// The part of all brightness that is above the mean, at most 1/2; 0 for a constant picture.
    float share() const { return share_; }

    float brightest() const { return brightest_; }  ///< channel of any pixel
    std::uint64_t hash() const { return hash_; }    ///< XXH3 of size and pixels

private:
    struct Axis {
        int low, high;  // pixels on both sides
        float fraction;
    };
    Axis across(float u) const;
    Axis down(float v) const;
    float excess_of(Rgb pixel) const;                       // brightness above the mean
    float excess(int x, int y) const;                       // of a pixel
    float node(std::size_t column, std::size_t row) const;  // excess at a corner of cells
    float node_u(std::size_t column) const;
    float node_v(std::size_t row) const;
    float row_weight(std::size_t row) const;  // g
    double mean_brightness() const;
    void tabulate();

    RgbImage image_;
    Layout layout_;
    float mean_ = 0, share_ = 0, brightest_ = 0;
    double total_ = 0;  // integral of e g over the square
    std::uint64_t hash_ = 0;
    // Cells lie between pixel centres and the edges: (width + 1) by (height + 1). Probabilities up
    // to and with each row, and within a row up to and with each cell.
    std::vector<float> row_end_;   // [row]
    std::vector<float> cell_end_;  // [row * (width + 1) + column]
};

}  // namespace tallow
