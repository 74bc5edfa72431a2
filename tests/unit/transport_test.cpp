// SPDX-License-Identifier: Apache-2.0
// The walk against published numbers, the stored table against the walk and against mathematics,
// and the profile against the table. Seeds are fixed, so nothing here fails by chance twice: a seed
// that lands outside of three standard errors (0.3 %) would have failed when it was written.
#include <gtest/gtest.h>

#include <fstream>
#include <numbers>
#include <sstream>

#include "common/optics/random_walk.h"
#include "common/optics/single_scattering.h"
#include "common/optics/transport_data.h"
#include "common/optics/transport_walk.h"
#include "profile_cases.h"

namespace tallow {
namespace {

using Grid = TransportGrid;
using test::grey_medium;

struct Reflection {
    Estimate reflected, transmitted;
};

// Walks a slab at a given albedo; errors from 50 batches.
Reflection walk_slab(const Slab& slab, double alpha, int walks_per_batch) {
    constexpr int kBatches = 50, kMaxOrder = 600;
    double sum[2] = {}, sum2[2] = {};
    for (int batch = 0; batch < kBatches; ++batch) {
        double light[2] = {};
        for (int i = 0; i < walks_per_batch; ++i) {
            WalkRandom random(3, std::uint64_t(batch * walks_per_batch + i));
            random_walk(slab, kMaxOrder, random, [&](const Escape& escape) {
                light[escape.top ? 0 : 1] += escape.weight * std::pow(alpha, escape.order);
            });
        }
        for (int side = 0; side < 2; ++side) {
            const double mean = light[side] / walks_per_batch;
            sum[side] += mean, sum2[side] += mean * mean;
        }
    }
    const auto estimate = [&](int side) {
        const double mean = sum[side] / kBatches;
        const double variance = (sum2[side] / kBatches - mean * mean) / (kBatches - 1);
        return Estimate{mean, std::sqrt(variance)};
    };
    return {estimate(0), estimate(1)};
}

ReducedChannel channel_of(double absorption, double eta) {
    return {1 - absorption, absorption, 1, eta};
}

// [vdH80]: mu_a 10, mu_s 90 per cm, g 0.75, 0.02 cm thick, matched indices.
TEST(RandomWalk, VanDeHulstsSlab) {
    const auto [R, T] = walk_slab({.eta = 1, .g = 0.75f, .thickness = 2}, 0.9, 4000);
    EXPECT_LT(R.error, 6e-4);
    EXPECT_NEAR(R.value, 0.09739, 3 * R.error);
    EXPECT_NEAR(T.value, 0.66096, 3 * T.error);
}

// [Giov55]: half-space of index 1.5, mu_a 10, mu_s 90 per cm, isotropic, light at right angles;
// 0.2600 with the surface's own reflection of 0.04.
TEST(RandomWalk, GiovanellisHalfSpace) {
    const Reflection light = walk_slab({.eta = 1.5}, 0.9, 4000);
    const double specular = fresnel_reflectance(1.5, 1.0);
    EXPECT_LT(light.reflected.error, 1e-3);
    EXPECT_NEAR(specular + (1 - specular) * light.reflected.value, 0.2600,
                3 * light.reflected.error + 5e-5);  // printed to four digits
    EXPECT_EQ(light.transmitted.value, 0);
}

// Without absorption whatever enters a slab leaves it.
TEST(RandomWalk, ASlabConservesLight) {
    const auto [R, T] = walk_slab({.eta = 1.3, .g = -0.5f, .thickness = 3}, 1, 1000);
    EXPECT_NEAR(R.value + T.value, 1, 3 * (R.error + T.error));
}

// H(1) of isotropic scattering by iterating 1/H = sqrt(1 - a) + a/2 * integral of x H(x) / (mu +
// x).
double chandrasekhar_H1(double alpha) {
    constexpr int n = 400;
    std::vector<double> H(n, 1.0);
    const auto next = [&](double mu) {
        double sum = 0;
        for (int j = 0; j < n; ++j) {
            const double x = (j + 0.5) / n;
            sum += x * H[std::size_t(j)] / (mu + x) / n;
        }
        return 1 / (std::sqrt(1 - alpha) + alpha / 2 * sum);
    };
    for (int iteration = 0; iteration < 60; ++iteration) {
        std::vector<double> better(n);
        for (int i = 0; i < n; ++i) better[std::size_t(i)] = next((i + 0.5) / n);
        H = better;
    }
    return next(1);
}

// Plane albedo for light at right angles, [Chan60]: 1 - sqrt(1 - alpha) H(1).
TEST(TransportTable, MatchedIndicesGiveChandrasekharsAlbedo) {
    for (const double absorption : {0.001, 0.01, 0.1, 0.3, 0.5, 0.8, 0.95}) {
        const double exact = 1 - std::sqrt(absorption) * chandrasekhar_H1(1 - absorption);
        const Estimate ours = transport_reflectance(channel_of(absorption, 1), Orders::all);
        EXPECT_NEAR(ours.value, exact, 3 * ours.error + 1e-5)
            << absorption;  // 1e-5: H by midpoints
        EXPECT_LT(ours.error, 7e-4);
    }
}

TEST(TransportTable, GiovanellisHalfSpace) {
    const Estimate inside = transport_reflectance(channel_of(0.1, 1.5), Orders::all);
    EXPECT_NEAR(0.04 + 0.96 * inside.value, 0.2600, 3 * inside.error + 5e-5);
}

// The file as it is, before conserve_energy(): all light comes back, within its error.
// 1.4: the entries are not quite independent, see transport_data.h.
TEST(TransportTable, StoredEnergyIsOne) {
    std::ifstream in(TALLOW_SOURCE_DIR "/data/transport/half_space.txt");
    std::stringstream text;
    text << in.rdbuf();
    double worst = 0;
    for (const TransportTable& table : read_transport_tables(text.str())) {
        double total = 0, variance = 0;
        for (const auto& ring : table.rings)
            for (const auto& entry : ring)
                total += entry.energy, variance += double(entry.error) * entry.error;
        worst = std::max(worst, std::abs(total - 1) / (1.4 * std::sqrt(variance)));
        EXPECT_LT(std::sqrt(variance), 2.5e-3) << table.eta;
    }
    EXPECT_LT(worst, 3);
}

TEST(TransportTable, HoldsTheIndicesOfThePresets) {
    for (const double eta : {1.0, 1.3, 1.33, 1.4, 1.43, 1.5, 2.0, 3.0})
        EXPECT_TRUE(std::ranges::any_of(transport_tables(), [&](const TransportTable& t) {
            return t.eta == eta;
        })) << eta;
}

// The first order is known in closed form.
TEST(TransportTable, FirstOrderIsSingleScattering) {
    for (const TransportTable& table : transport_tables()) {
        double total = 0, variance = 0;
        for (const auto& ring : table.rings)
            total += ring[0].energy, variance += double(ring[0].error) * ring[0].error;
        EXPECT_NEAR(total, single_scattering_reflectance(1, table.eta), 3.5 * std::sqrt(variance))
            << table.eta;
    }
}

// A short live walk is the stored table, within errors: ring by ring at one albedo.
TEST(TransportTable, IsWhatTheWalkGives) {
    const TransportTable live = walk_half_space(1.5, 64 * 256, 5);
    const auto stored = std::ranges::find(transport_tables(), 1.5, &TransportTable::eta);
    double chi2 = 0;
    int rings = 0;
    for (std::size_t ring = 20; ring < 50; ++ring) {  // r = 0.1 to 100
        double difference = 0, variance = 0;
        for (std::size_t bin = 0; bin < Grid::kOrderBins; ++bin) {
            const auto &a = live.rings[ring][bin], &b = stored->rings[ring][bin];
            difference += double(a.energy) - b.energy;
            variance += double(a.error) * a.error + double(b.error) * b.error;
        }
        chi2 += difference * difference / variance;
        ++rings;
    }
    EXPECT_LT(chi2, rings + 4 * std::sqrt(2.0 * rings));
    EXPECT_GT(chi2, rings - 4 * std::sqrt(2.0 * rings));
}

TEST(TransportTable, TextRoundTrip) {
    const TransportTable table = walk_half_space(1.2, 64 * 8, 1);
    const auto read = read_transport_tables("# comment\n" + write_transport_table(table, 1));
    ASSERT_EQ(read.size(), 1u);
    EXPECT_EQ(read[0].eta, 1.2);
    EXPECT_EQ(read[0].walks, 64 * 8);
    for (std::size_t ring = 0; ring < Grid::kRings; ++ring)
        for (std::size_t bin = 0; bin < Grid::kOrderBins; ++bin) {
            const auto &a = table.rings[ring][bin], &b = read[0].rings[ring][bin];
            if (a.energy < 2e-14) continue;  // e^-32 is stored as nothing
            ASSERT_NEAR(b.energy, a.energy, 2e-3 * a.energy) << ring << ' ' << bin;
        }
    EXPECT_THROW(read_transport_tables("eta 1.5 walks 10 seed 1\nABC\n"), std::logic_error);
}

TEST(TransportTable, GridCoversAllOrdersAndRadii) {
    EXPECT_EQ(Grid::bin_of(1), 0);
    EXPECT_EQ(Grid::bin_of(16), 15);
    EXPECT_EQ(Grid::bin_of(Grid::kLastOrder), Grid::kTailBin - 1);
    EXPECT_EQ(Grid::first_order(Grid::kTailBin), Grid::kLastOrder + 1);
    for (int bin = 1; bin < Grid::kOrderBins; ++bin) {
        EXPECT_EQ(Grid::bin_of(Grid::first_order(bin)), bin);
        EXPECT_EQ(Grid::bin_of(Grid::first_order(bin) - 1), bin - 1);
    }
    EXPECT_EQ(Grid::ring_of(0), 0);
    EXPECT_EQ(Grid::ring_of(1e30), Grid::kRings - 1);
    for (int ring = 1; ring < Grid::kRings - 1; ++ring) {
        const double outer = Grid::outer_radius(ring);
        EXPECT_EQ(Grid::ring_of(outer * outer * 0.9999), ring);
        EXPECT_EQ(Grid::ring_of(outer * outer * 1.0001), ring + 1);
    }
}

// Every index that has two neighbours on each side, from the others: over gaps twice as wide as
// those in use. The total, and each ring that is known to a percent. What is left is mostly the
// walks' own noise; four standard errors, for there are 500 rings.
TEST(TransportTable, InterpolatesBetweenIndices) {
    for (const double left_out : {1.2, 1.3, 1.33, 1.4, 1.43, 1.5, 1.6, 1.8, 2.0})
        for (const double absorption : {0.001, 0.05, 0.5}) {
            std::vector<double> etas;
            for (const TransportTable& table : transport_tables())
                if (table.eta != left_out) etas.push_back(table.eta);
            const auto weights = interpolation_weights(etas, left_out);
            const auto exact = transport_rings(channel_of(absorption, left_out));
            std::array<double, Grid::kRings> blend{}, variance{};
            for (std::size_t i = 0; i < etas.size(); ++i) {
                if (weights[i] == 0) continue;
                const auto rings = transport_rings(channel_of(absorption, etas[i]));
                for (std::size_t ring = 0; ring < rings.size(); ++ring) {
                    blend[ring] += weights[i] * rings[ring].value;
                    variance[ring] += std::pow(weights[i] * rings[ring].error, 2);
                }
            }
            double total = 0, total_blend = 0;
            for (std::size_t ring = 0; ring < exact.size(); ++ring) {
                total += exact[ring].value, total_blend += blend[ring];
                if (exact[ring].value < 1e-8 || exact[ring].error > 0.01 * exact[ring].value)
                    continue;
                const double noise =
                    std::sqrt(variance[ring] + exact[ring].error * exact[ring].error);
                EXPECT_NEAR(blend[ring], exact[ring].value, 0.005 * exact[ring].value + 4 * noise)
                    << left_out << ' ' << absorption << " ring " << ring;
            }
            EXPECT_NEAR(total_blend / total, 1, 0.006) << left_out << ' ' << absorption;
        }
}

TEST(TransportTable, InterpolationIsExactAtTheTables) {
    const std::vector<double> etas{0.7, 0.85, 1, 1.2, 1.5, 2, 3};
    for (std::size_t i = 0; i < etas.size(); ++i) {
        const auto weights = interpolation_weights(etas, etas[i]);
        for (std::size_t j = 0; j < etas.size(); ++j)
            EXPECT_NEAR(weights[j], i == j ? 1 : 0, 1e-12);
    }
    // A cubic in 1 / eta above 1, and nothing of what is below.
    const auto weights = interpolation_weights(etas, 1.1);
    double sum = 0, cubic = 0;
    for (std::size_t j = 0; j < etas.size(); ++j)
        sum += weights[j], cubic += weights[j] * std::pow(etas[j], -3);
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_NEAR(cubic, std::pow(1.1, -3), 1e-12);
    EXPECT_EQ(weights[1], 0);
}

// The smooth profile against the rings it was fitted to: nothing but noise may be left.
TEST(TransportProfile, StaysWithinTheStatisticalError) {
    for (const double eta : {1.0, 1.3, 1.5, 2.0})
        for (const double absorption : {0.0, 0.001, 0.05, 0.5}) {
            const auto profile = make_profile(
                Model::transport, grey_medium(absorption, 1, float(eta)), 0, Orders::two_and_more);
            const auto rings = transport_rings(channel_of(absorption, eta));
            double chi2 = 0;
            int count = 0;
            for (int ring = 8; ring < Grid::kRings - 1; ++ring) {
                const double low = Grid::outer_radius(ring - 1), high = Grid::outer_radius(ring);
                double sum = 0;
                const double h = std::log(high / low) / 20;
                for (int i = 0; i < 20; ++i) {
                    const double r = low * std::exp((i + 0.5) * h);
                    sum += 2 * std::numbers::pi * r * r * h * (*profile)(r * r - 1e-6);
                }
                const Estimate& walked = rings[std::size_t(ring)];
                if (walked.value < 1e-7) continue;
                // 0.3 %: quantisation of the file, and a monotone cubic across a ring.
                const double error = walked.error + 0.003 * walked.value;
                chi2 += std::pow((sum - walked.value) / error, 2);
                ++count;
            }
            EXPECT_LT(chi2, count + 3 * std::sqrt(2.0 * count)) << eta << ' ' << absorption;
        }
}

// Between the tables, and for every albedo, the fit keeps what Profile promises.
TEST(TransportProfile, FallsAtAnyIndexAndAlbedo) {
    for (float eta = 0.7f; eta <= 3.0f; eta += 0.037f)
        for (const double absorption : {0.0, 1e-7, 1e-5, 3e-4, 0.02, 0.4, 0.97, 1 - 1e-5}) {
            const auto profile = make_profile(Model::transport, grey_medium(absorption, 1, eta), 0,
                                              Orders::two_and_more);
            const double total = profile->total_reflectance();
            EXPECT_TRUE(total > 0 && total < 1) << eta << ' ' << absorption;
            double previous = (*profile)(0);
            for (double r = 1e-4; r < 1e4; r *= 1.1) {
                const double value = (*profile)(r * r);
                ASSERT_TRUE(value >= 0 && value <= previous * (1 + 1e-12))
                    << eta << ' ' << absorption << ' ' << r << ": " << value << ' ' << previous;
                previous = value;
            }
        }
}

TEST(TransportProfile, TotalIsThatOfTheTable) {
    for (const double eta : {1.0, 1.3, 1.38, 1.5, 3.0})
        for (const double absorption : {0.0, 0.001, 0.05, 0.5, 0.95})
            for (const Orders orders : {Orders::all, Orders::two_and_more}) {
                const auto profile = make_profile(
                    Model::transport, grey_medium(absorption, 1, float(eta)), 0, orders);
                const Estimate total = transport_reflectance(channel_of(absorption, eta), orders);
                // The first order leaves up to 5e-4 alpha' inside of kInnermost, where the profile
                // is softened; the others next to nothing.
                const double centre = orders == Orders::all ? 5e-4 * (1 - absorption) : 0;
                EXPECT_NEAR(profile->total_reflectance(), total.value,
                            total.error + 1e-4 * total.value + centre)
                    << eta << ' ' << absorption;
            }
}

}  // namespace
}  // namespace tallow
