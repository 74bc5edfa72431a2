// SPDX-License-Identifier: Apache-2.0
#include "material/describe_material.h"

#include <cmath>

#include "common/optics/dipole.h"
#include "common/optics/fresnel.h"

namespace tallow {
namespace {

void describe_channel(const Medium& medium, std::size_t c, MaterialReport& report) {
    const int channel = int(c);
    const double sigma_a = double(medium.sigma_a[channel]);
    const double sigma_s_prime = double(medium.sigma_s_prime[channel]);
    const double sigma_s = sigma_s_prime / (1 - double(medium.g));
    const double sigma_t_prime = sigma_s_prime + sigma_a;
    const auto dipole = dipole_channel<double>(medium, channel, report.A);
    report.sigma_a[c] = sigma_a;
    report.sigma_s_prime[c] = sigma_s_prime;
    report.sigma_s[c] = sigma_s;
    report.sigma_t[c] = sigma_s + sigma_a;
    report.sigma_t_prime[c] = sigma_t_prime;
    report.sigma_tr[c] = dipole.sigma_tr;
    report.alpha_prime[c] = dipole.alpha_prime;
    report.albedo[c] = sigma_s / (sigma_s + sigma_a);
    report.mean_free_path_mm[c] = 1 / sigma_t_prime;
    report.z_r_mm[c] = dipole.z_r;
    report.z_v_mm[c] = dipole.z_v;
}

ModelReport describe_model(std::string_view name, Model model, const Medium& medium,
                           std::span<const double> radii_mm) {
    ModelReport report{std::string(name), {}, std::vector<Triple>(radii_mm.size())};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto profile = make_profile(model, medium, int(c), Orders::all);
        report.total_reflectance[c] = profile->total_reflectance();
        for (std::size_t i = 0; i < radii_mm.size(); ++i)
            report.profile[i][c] = (*profile)(radii_mm[i] * radii_mm[i]);
    }
    return report;
}

double round_to_digits(double x, int digits) {
    const double unit = std::pow(10, std::floor(std::log10(x)) - digits + 1);
    return std::round(x / unit) * unit;
}

}  // namespace

MaterialReport describe_material(const Medium& medium, std::span<const double> radii_mm) {
    MaterialReport report{};
    report.g = double(medium.g);
    report.eta = double(medium.eta);
    report.F_dr = diffuse_fresnel_reflectance(report.eta);
    report.A = mismatch_A(report.eta);
    for (std::size_t c = 0; c < 3; ++c) describe_channel(medium, c, report);
    report.radii_mm.assign(radii_mm.begin(), radii_mm.end());
    for (const auto& [name, model] : kModels)
        report.models.push_back(describe_model(name, model, medium, radii_mm));
    return report;
}

std::vector<double> default_radii(const Medium& medium) {
    const Rgb length = medium.mean_free_path();
    const double mean = std::cbrt(double(length.r) * double(length.g) * double(length.b));
    std::vector<double> radii;
    for (double paths : {0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0})
        radii.push_back(round_to_digits(paths * mean, 3));
    return radii;
}

}  // namespace tallow
