// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "common/optics/profile.h"

namespace tallow {

/// How a profile is averaged over its plane: with g of standard deviation sigma, a Gaussian that is
/// sharpened by t, so that what varies slowly is blurred less.
///
///     g(r) = (1 + t - t r^2 / 2 sigma^2) e^(-r^2 / 2 sigma^2) / (2 pi sigma^2)
///     g^(k) = (1 + t k^2 sigma^2 / 2) e^(-k^2 sigma^2 / 2)
///
/// At t = 0 it blurs as sigma^2, at t = 1 as sigma^4, but has a negative rim.
struct Smoothing {
    double sigma;  // mm, > 0
    double t = 0;  // in [0, 1]
};

/// R * g: what a sum over samples that are farther apart than the profile is wide can resolve.
///
/// Units    as Profile.
/// Domain   sigma from 0.01 to 100 mean free paths; t > 0 only where R is wider than g, so that
///          R * g stays positive.
/// Error    relative: 1e-7 for the dipole, against quadrature by polar coordinates up to 9 mean
/// free
///          paths; of the plane integral 6e-7 for `transport`, 4e-8 for the others. Where R * g
///          falls below 1e-15 of the total per sigma^2 (or mean free path^2) it is taken for 0.
class SmoothedProfile final : public Profile {
public:
    /// `mean_free_path` [mm] is the distance over which `profile` varies.
    SmoothedProfile(const Profile& profile, double mean_free_path, Smoothing smoothing);
    ~SmoothedProfile() override;

    double operator()(double r2) const override;
    double total_reflectance() const override { return total_; }

private:
    struct Curve;
    double sigma_, total_, end_;
    std::unique_ptr<Curve> curve_;
};

/// How much of a profile lies nearer than what sums over samples can resolve, as plane integrals of
/// R with two weights. Both go to R's own integral where sigma is large against R, and to 0 where
/// it is small. With R^, g^ the transforms over the plane:
///
///     beta  = integral of R^ (1 - g^)^2 / k^2 dk / integral of (1 - g^)^2 / k^2 dk
///     kappa = integral of R^ k^5 (g^)^2 dk / integral of k^5 (g^)^2 dk
///           = integral of R(r) (1 - 2 q + q^2 / 2) e^-q dA,     q = r^2 / 4 sigma^2
///
/// beta: with the weight beta at the point itself and (R - beta) * g for the rest, irradiance with
/// straight edges, whose spectrum falls as 1 / k^2, comes closest to that with R. kappa: what R
/// makes of the noise of sums with g; samples that are spread evenly have a noise that grows as
/// k^4.
///
/// Units    1; `centre`, which is (R * g)(0), 1/mm^2.
struct NearbyParts {
    double beta, kappa, centre;
};
NearbyParts nearby_parts(const Profile& profile, double mean_free_path, double sigma);

}  // namespace tallow
