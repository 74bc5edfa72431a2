// SPDX-License-Identifier: Apache-2.0
// Formulas at the ends of their domains, against 50 digits.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>

#include "common/nbody/kernel_table.h"
#include "common/optics/dipole.h"
#include "common/optics/fresnel.h"
#include "common/optics/phase.h"
#include "tests/hard_cases/hard_cases.h"

namespace tallow::test {
namespace {

using Real = boost::multiprecision::cpp_bin_float_50;

const Real kRealPi = boost::math::constants::pi<Real>();

double relative(double value, const Real& expected) {
    return double(abs(Real(value) - expected) / abs(expected));
}

// The dipole of a medium, from its coefficients, in 50 digits. A is that of the double version: it
// is tested in fresnel_test.
struct RealDipole {
    Real alpha, sigma_tr, z_r, z_v;

    RealDipole(const Medium& m, int c) {
        const Real a = double(m.sigma_a[c]), s = double(m.sigma_s_prime[c]);
        alpha = s / (s + a);
        sigma_tr = sqrt(3 * a * (s + a));
        z_r = 1 / (s + a);
        z_v = z_r * (1 + Real(4) * mismatch_A(m.eta) / 3);
    }
    Real pole(const Real& z, const Real& r2) const {
        const Real d = sqrt(r2 + z * z), x = sigma_tr * d;
        return z * (1 + x) * exp(-x) / (d * d * d);
    }
    Real R(double r2) const { return alpha / (4 * kRealPi) * (pole(z_r, r2) + pole(z_v, r2)); }
    Real total() const { return alpha / 2 * (exp(-sigma_tr * z_r) + exp(-sigma_tr * z_v)); }
};

Medium grey(float sigma_a, float sigma_s_prime, float eta = 1.3f) {
    return {Rgb(sigma_a), Rgb(sigma_s_prime), 0, eta};
}

struct MediumCase {
    std::string name;
    Medium medium;
};

const std::vector<MediumCase> kMedia = {
    {"sigma_a = 0", grey(0, 1)},          {"sigma_a = 1e-12", grey(1e-12f, 1)},
    {"alpha' = 1e-6", grey(1, 1e-6f)},    {"alpha' = 1 - 1e-9", grey(1e-9f, 1)},
    {"eta = 1", grey(0.01f, 1, 1)},       {"eta = 0.75", grey(0.01f, 1, 0.75f)},
    {"eta = 3", grey(0.01f, 1, 3)},       {"sigma_t' = 1e-6", grey(1e-8f, 1e-6f)},
    {"sigma_t' = 1e6", grey(1e4f, 1e6f)},
};

TEST(HardOptics, DipoleAtExtremeMedia) {
    for (const auto& [name, medium] : kMedia) {
        const auto profile = make_profile(Model::dipole, medium, 0, Orders::all);
        const RealDipole exact(medium, 0);
        const double mfp = medium.mean_free_path().r;
        double error = 0;
        for (double r : {0.0, 1e-9, 1e-3, 1.0, 10.0}) {
            const double r2 = r * mfp * r * mfp;
            error = std::max(error, relative((*profile)(r2), exact.R(r2)));
        }
        expect_within("dipole R(r), r = 0 to 10 mfp, " + name, "50 digits", error, 1e-13);
        expect_within("dipole total reflectance, " + name, "closed form, 50 digits",
                      relative(profile->total_reflectance(), exact.total()), 1e-13);
    }
}

TEST(HardOptics, DipoleFarAway) {
    const Medium medium = grey(0.01f, 1);
    const auto profile = make_profile(Model::dipole, medium, 0, Orders::all);
    const double r2 = std::pow(1e4 * medium.mean_free_path().r, 2);
    const Real exact = RealDipole(medium, 0).R(r2);
    expect_within("dipole R(1e4 mfp), below the smallest double", "50 digits, absolute",
                  std::abs((*profile)(r2) - double(exact)), 1e-300);
}

// Largest relative growth of a profile from r = 0 to 1e4 mfp; NaN if it or its table is ever
// negative or not finite.
double largest_growth(Model model, const Medium& medium) {
    const auto profile = make_profile(model, medium, 0, Orders::two_and_more);
    const double mfp = medium.mean_free_path().r;
    const KernelTable table = tabulate(*profile, mfp, KernelTable::unit_near(mfp));
    double previous = (*profile)(0), growth = 0;
    for (double r = 1e-9; r <= 1e4; r *= 1.5) {
        const double r2 = r * mfp * r * mfp, value = (*profile)(r2), fast = table(float(r2));
        if (!(value >= 0) || !(fast >= 0) || !std::isfinite(previous + fast)) return NAN;
        growth = std::max(growth, value / previous - 1);
        if (value > 0) previous = value;
    }
    return growth;
}

TEST(HardOptics, EveryModelStaysFiniteAndFalls) {
    for (const auto& [model_name, model] : kModels) {
        double growth = 0;
        for (const auto& [name, medium] : kMedia)
            growth = std::max(growth, largest_growth(model, medium));
        expect_within(fmt::format("{}: finite, >= 0 and falling, r = 0 to 1e4 mfp, all these media",
                                  model_name),
                      "largest relative growth", growth, 1e-9);
    }
}

TEST(HardOptics, NoScatteringAtAll) {
    for (const auto& [model_name, model] : kModels) {
        const auto profile = make_profile(model, grey(1, 0), 0, Orders::all);
        expect_within(fmt::format("{}: sigma_s = 0", model_name), "total reflectance 0, absolute",
                      std::abs(profile->total_reflectance() + (*profile)(0) + (*profile)(1)), 0);
    }
}

TEST(HardOptics, FresnelAtGrazingAndCriticalAngles) {
    const auto exact = [](double eta_d, double mu_d) {
        const Real eta = eta_d, mu = mu_d, cos_t = sqrt(1 - (1 - mu * mu) / (eta * eta));
        const Real a = (eta * mu - cos_t) / (eta * mu + cos_t),
                   b = (mu - eta * cos_t) / (mu + eta * cos_t);
        return Real(1 - (a * a + b * b) / 2);
    };
    expect_within("F_t at cos 1e-8, eta 1.5", "50 digits",
                  relative(1 - fresnel_reflectance(1.5, 1e-8), exact(1.5, 1e-8)), 1e-8);
    expect_within("F_t at cos 1e-4, eta 1.5, float", "50 digits",
                  relative(fresnel_transmittance(1.5f, 1e-4f), exact(1.5, double(1e-4f))), 1e-3);
    const double eta = 1 / 1.5, mu_c = std::sqrt(1 - eta * eta) + 1e-10;
    expect_within("F_t 1e-10 inside the critical angle, eta 1/1.5", "50 digits",
                  relative(1 - fresnel_reflectance(eta, mu_c), exact(eta, mu_c)), 1e-5);
}

TEST(HardOptics, PhaseFunctionAtItsPeak) {
    for (double g : {0.9999, -0.9999, 1e-8})
        for (double cosine : {1.0, 0.0, -1.0}) {
            const Real G = double(float(g)), C = cosine, base = 1 + G * G - 2 * G * C;
            const Real exact = (1 - G * G) / (4 * kRealPi * base * sqrt(base));
            expect_within(fmt::format("Henyey-Greenstein, g = {}, cos = {}", g, cosine),
                          "50 digits", relative(henyey_greenstein(float(g), float(cosine)), exact),
                          1e-3);
        }
}

}  // namespace
}  // namespace tallow::test
