// SPDX-License-Identifier: Apache-2.0
#include "material/material_json.h"

#include <nlohmann/json.hpp>

namespace tallow {
namespace {

using Json = nlohmann::ordered_json;  // keys in the order in which they are written here

Json model_json(const ModelReport& model, const std::vector<double>& radii_mm) {
    Json profile = Json::array();
    for (std::size_t i = 0; i < radii_mm.size(); ++i) {
        const Triple& R = model.profile[i];
        profile.push_back({radii_mm[i], R[0], R[1], R[2]});
    }
    return {{"total_reflectance", model.total_reflectance}, {"profile", profile}};
}

}  // namespace

std::string material_json(const MaterialReport& report) {
    Json json = {{"sigma_a", report.sigma_a},
                 {"sigma_s_prime", report.sigma_s_prime},
                 {"g", report.g},
                 {"eta", report.eta},
                 {"alpha_prime", report.alpha_prime},
                 {"sigma_tr", report.sigma_tr},
                 {"mean_free_path_mm", report.mean_free_path_mm},
                 {"F_dr", report.F_dr},
                 {"A", report.A},
                 {"z_r_mm", report.z_r_mm},
                 {"z_v_mm", report.z_v_mm},
                 {"models", Json::object()}};
    for (const ModelReport& model : report.models)
        json["models"][model.name] = model_json(model, report.radii_mm);
    return json.dump(2) + "\n";
}

}  // namespace tallow
