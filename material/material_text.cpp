// SPDX-License-Identifier: Apache-2.0
#include "material/material_text.h"

#include <fmt/format.h>

namespace tallow {
namespace {

std::string header(const std::string& first, const std::string& unit) {
    return fmt::format("{:<28}{:>12}{:>12}{:>12}  {}\n", first, "red", "green", "blue", unit);
}

std::string row(const std::string& name, const Triple& x, const std::string& unit) {
    return fmt::format("{:<28}{:>12.5g}{:>12.5g}{:>12.5g}  {}\n", name, x[0], x[1], x[2], unit);
}

std::string row(const std::string& name, double x, const std::string& unit) {
    return fmt::format("{:<28}{:>12.5g}{:>24}  {}\n", name, x, "", unit);
}

std::string quantities(const MaterialReport& m) {
    return header("", "unit, meaning") + row("sigma_a", m.sigma_a, "1/mm  absorption") +
           row("sigma_s'", m.sigma_s_prime, "1/mm  reduced scattering") +
           row("sigma_s", m.sigma_s, "1/mm  scattering, sigma_s' / (1 - g)") +
           row("sigma_t", m.sigma_t, "1/mm  extinction") +
           row("sigma_t'", m.sigma_t_prime, "1/mm  reduced extinction") +
           row("sigma_tr", m.sigma_tr, "1/mm  effective transport, sqrt(3 sigma_a sigma_t')") +
           row("alpha'", m.alpha_prime, "1     reduced albedo, sigma_s' / sigma_t'") +
           row("albedo", m.albedo, "1     sigma_s / sigma_t") +
           row("mean free path", m.mean_free_path_mm, "mm    1 / sigma_t'") +
           row("z_r", m.z_r_mm, "mm    depth of the dipole's real source") +
           row("z_v", m.z_v_mm, "mm    height of its virtual source") +
           row("eta", m.eta, "1     index of refraction, inside / outside") +
           row("g", m.g, "1     mean cosine of scattering") +
           row("F_dr", m.F_dr, "1     diffuse Fresnel reflectance from inside") +
           row("A", m.A, "1     (1 + F_dr) / (1 - F_dr)");
}

std::string totals(const MaterialReport& m) {
    std::string text = header("total reflectance", "");
    for (const ModelReport& model : m.models) text += row(model.name, model.total_reflectance, "1");
    return text;
}

std::string profiles(const MaterialReport& m) {
    std::string text;
    for (const ModelReport& model : m.models) {
        text += fmt::format("\n{}", header("R(r), " + model.name, ""));
        for (std::size_t i = 0; i < m.radii_mm.size(); ++i)
            text += row(fmt::format("r = {:g} mm", m.radii_mm[i]), model.profile[i], "1/mm^2");
    }
    return text;
}

}  // namespace

std::string material_text(const std::string& title, const MaterialReport& report) {
    return fmt::format("{}\n\n{}\n{}{}", title, quantities(report), totals(report),
                       profiles(report));
}

}  // namespace tallow
