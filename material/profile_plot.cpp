// SPDX-License-Identifier: Apache-2.0
// Medium -> profiles sampled along log r -> SVG. The three panels share their axes' ranges, so that
// channels compare at a glance.
#include "material/profile_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/optics/profile.h"

namespace tallow {
namespace {

// Pixels.
constexpr double kPanelWidth = 330, kPanelHeight = 330, kPanelGap = 38;
constexpr double kLeft = 78, kTop = 64, kRight = 24, kBottom = 58;
constexpr double kWidth = kLeft + 3 * kPanelWidth + 2 * kPanelGap + kRight;
constexpr double kHeight = kTop + kPanelHeight + kBottom;
constexpr double kLegendLine = 16;

constexpr int kPoints = 160;          // of a curve: two pixels apart
constexpr int kDecadesOfR = 8;        // below the largest value nothing is left to see
constexpr double kSmallest = 1e-300;  // keeps the logarithm of an underflowed value finite

// Colours that colour-blind readers can tell apart (Okabe, Ito 2008), in the order of kModels, and
// dashes that printers can.
struct Style {
    const char *colour, *dash;
    double width;
};
constexpr std::array<Style, kModels.size()> kStyles = {{{"#000000", "", 1.6},
                                                        {"#8a8a8a", "6 3", 1.6},
                                                        {"#0072b2", "", 1.6},
                                                        {"#e69f00", "8 3 2 3", 1.8},
                                                        {"#009e73", "", 1.6},
                                                        {"#d55e00", "", 2.4},
                                                        {"#cc79a7", "4 2", 1.8}}};

struct Curve {
    double total_reflectance;
    std::array<double, kPoints> log_R;  // log10 of 1/mm^2
};
using Panel = std::array<Curve, kModels.size()>;

/// Whole decades: log10 of the ends of both axes.
struct Axes {
    int r_low, r_high, R_low, R_high;

    double log_r(int point) const {
        return r_low + (r_high - r_low) * double(point) / (kPoints - 1);
    }
    double x(double log_r) const { return kPanelWidth * (log_r - r_low) / (r_high - r_low); }
    double y(double log_R) const { return kPanelHeight * (1 - (log_R - R_low) / (R_high - R_low)); }
};

Axes distance_axis(const Medium& medium) {
    const Rgb length = medium.mean_free_path();
    return {int(std::floor(std::log10(min_channel(length) / 50))),
            int(std::ceil(std::log10(max_channel(length) * 20))), 0, 0};
}

std::array<Panel, 3> sample_curves(const Medium& medium, const Axes& axes) {
    std::array<Panel, 3> panels{};
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t m = 0; m < kModels.size(); ++m) {
            const auto profile = make_profile(kModels[m].second, medium, int(c), Orders::all);
            Curve& curve = panels[c][m];
            curve.total_reflectance = profile->total_reflectance();
            for (int i = 0; i < kPoints; ++i) {
                const double r = std::pow(10, axes.log_r(i));
                curve.log_R[std::size_t(i)] = std::log10(std::max((*profile)(r * r), kSmallest));
            }
        }
    return panels;
}

void fit_reflectance_axis(const std::array<Panel, 3>& panels, Axes& axes) {
    double largest = std::log10(kSmallest);
    for (const Panel& panel : panels)
        for (const Curve& curve : panel) largest = std::max(largest, curve.log_R.front());
    axes.R_high = int(std::ceil(largest));
    axes.R_low = axes.R_high - kDecadesOfR;
}

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '&')
            result += "&amp;";
        else if (c == '<')
            result += "&lt;";
        else if (c == '>')
            result += "&gt;";
        else
            result += c;
    }
    return result;
}

std::string power_of_ten(int exponent) {
    return fmt::format("10<tspan dy=\"-5\" font-size=\"9\">{}</tspan>", exponent);
}

std::string line(double x1, double y1, double x2, double y2, const char* style) {
    return fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", x1, y1,
        x2, y2, style);
}

std::string distance_grid(const Axes& axes) {
    std::string svg;
    for (int decade = axes.r_low; decade <= axes.r_high; ++decade) {
        svg += line(axes.x(decade), 0, axes.x(decade), kPanelHeight, "decade");
        svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                           axes.x(decade), kPanelHeight + 20, power_of_ten(decade));
        for (int step = 2; step < 10 && decade < axes.r_high; ++step) {
            const double x = axes.x(decade + std::log10(step));
            svg += line(x, kPanelHeight, x, kPanelHeight - 4, "tick");
        }
    }
    return svg;
}

std::string reflectance_grid(const Axes& axes, bool with_labels) {
    std::string svg;
    for (int decade = axes.R_low; decade <= axes.R_high; ++decade) {
        svg += line(0, axes.y(decade), kPanelWidth, axes.y(decade), "decade");
        if (with_labels)
            svg += fmt::format("<text x=\"-8\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n",
                               axes.y(decade) + 4, power_of_ten(decade));
    }
    return svg;
}

std::string stroke(const Style& style) {
    return fmt::format("stroke=\"{}\" stroke-width=\"{}\" stroke-dasharray=\"{}\"", style.colour,
                       style.width, *style.dash ? style.dash : "none");
}

std::string curve_svg(const Curve& curve, const Axes& axes, const Style& style) {
    std::string points;
    for (int i = 0; i < kPoints; ++i) {
        // Far below the panel is clipped anyway; near it keeps the numbers short.
        const double y = std::min(axes.y(curve.log_R[std::size_t(i)]), 2 * kPanelHeight);
        points += fmt::format("{:.1f},{:.1f} ", axes.x(axes.log_r(i)), y);
    }
    points.pop_back();
    return fmt::format("<polyline points=\"{}\" fill=\"none\" {}/>\n", points, stroke(style));
}

std::string legend(const Panel& panel) {
    const double height = kLegendLine * double(kModels.size() + 1) + 8;
    const double top = kPanelHeight - height - 10;
    std::string svg = fmt::format(
        "<rect x=\"10\" y=\"{:.1f}\" width=\"214\" height=\"{:.1f}\" class=\"legend\"/>\n"
        "<text x=\"218\" y=\"{:.1f}\" text-anchor=\"end\" class=\"small\">total "
        "reflectance</text>\n",
        top, height, top + kLegendLine - 2);
    for (std::size_t m = 0; m < kModels.size(); ++m) {
        const double y = top + kLegendLine * double(m + 2) - 2;
        svg += fmt::format("<path d=\"M16 {0:.1f}h26\" fill=\"none\" {1}/>\n", y - 4,
                           stroke(kStyles[m]));
        svg += fmt::format(
            "<text x=\"48\" y=\"{0:.1f}\" class=\"small\">{1}</text>"
            "<text x=\"218\" y=\"{0:.1f}\" text-anchor=\"end\" class=\"small\">{2:.4f}"
            "</text>\n",
            y, kModels[m].first, panel[m].total_reflectance);
    }
    return svg;
}

std::string panel_svg(const Panel& panel, const Axes& axes, std::size_t channel) {
    constexpr std::array<const char*, 3> kNames = {"red", "green", "blue"};
    std::string svg = fmt::format("<g transform=\"translate({} {})\">\n",
                                  kLeft + double(channel) * (kPanelWidth + kPanelGap), kTop);
    svg += distance_grid(axes) + reflectance_grid(axes, channel == 0);
    svg += fmt::format("<text x=\"{}\" y=\"-8\" text-anchor=\"middle\">{}</text>\n",
                       kPanelWidth / 2, kNames[channel]);
    svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">distance r in mm</text>\n",
                       kPanelWidth / 2, kPanelHeight + 42);
    svg += "<g clip-path=\"url(#panel)\">\n";
    for (std::size_t m = 0; m < kModels.size(); ++m) svg += curve_svg(panel[m], axes, kStyles[m]);
    svg += "</g>\n";
    svg += legend(panel);
    svg += fmt::format("<rect width=\"{}\" height=\"{}\" class=\"frame\"/>\n</g>\n", kPanelWidth,
                       kPanelHeight);
    return svg;
}

std::string head(const std::string& title) {
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
        "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"13\">\n"
        "<style>.decade{{stroke:#e4e4e4}} .tick{{stroke:#666}} .frame{{fill:none;stroke:#444}} "
        ".legend{{fill:#fff;fill-opacity:0.88;stroke:#ccc}} .small{{font-size:11px}}</style>\n"
        "<clipPath id=\"panel\"><rect width=\"{2}\" height=\"{3}\"/></clipPath>\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        "<text x=\"{4}\" y=\"26\" font-size=\"16\">{5}</text>\n"
        "<text transform=\"translate(20 {6}) rotate(-90)\" text-anchor=\"middle\">"
        "R(r) in 1/mm\u00b2</text>\n",
        kWidth, kHeight, kPanelWidth, kPanelHeight, kLeft, escaped(title), kTop + kPanelHeight / 2);
}

}  // namespace

std::string profile_plot(const std::string& title, const Medium& medium) {
    Axes axes = distance_axis(medium);
    const auto panels = sample_curves(medium, axes);
    fit_reflectance_axis(panels, axes);
    std::string svg = head(title);
    for (std::size_t c = 0; c < 3; ++c) svg += panel_svg(panels[c], axes, c);
    return svg + "</svg>\n";
}

}  // namespace tallow
