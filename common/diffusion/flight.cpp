// SPDX-License-Identifier: Apache-2.0
#include "common/diffusion/flight.h"

#include <algorithm>
#include <cmath>

namespace tallow {

Collisions::Collisions(const Flight& flight, double mean_free_path)
    : flight_(flight), mean_free_path_(mean_free_path) {
    double before = 0;  // ways of the legs until here
    for (std::size_t i = 0; i < Flight::kLegs; ++i) {
        const Flight::Leg& leg = flight.legs[i];
        share_[i] = double(leg.share) * std::exp(-before / mean_free_path);
        total_ += share_[i] * -std::expm1(-double(leg.length) / mean_free_path);
        until_[i] = total_;
        before += double(leg.length);
        if (leg.share == 0) break;
    }
}

Vec3 Collisions::at(double u) const {
    Vec3 start(0);
    double scattered = 0;
    for (std::size_t i = 0;; ++i) {
        const Flight::Leg& leg = flight_.legs[i];
        const bool last = i + 1 == Flight::kLegs || share_[i + 1] == 0;
        if (last || u * total_ < until_[i]) {
            const double on_leg = share_[i] > 0 ? (u * total_ - scattered) / share_[i] : 0;
            const double way = -mean_free_path_ * std::log1p(-std::min(on_leg, 1 - 1e-9));
            return start + std::min(float(way), leg.length) * leg.w;
        }
        start += leg.length * leg.w;
        scattered = until_[i];
    }
}

}  // namespace tallow
