// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/reference/film.h"

namespace tallow::reference {

/// Sums over independent batches, from which means and their variances come.
class Accumulator {
public:
    explicit Accumulator(std::size_t pixels);

    void add(const Film& batch);

    std::uint64_t batches() const { return batches_; }

    /// Mean of a layer, [pixel].
    std::vector<double> mean(int layer, int channel) const;
    /// Mean of single + multi + ext.
    std::vector<double> scattered(int channel) const;

    /// Variance of mean(), [pixel]: that of the batches over their number. Zeros for one batch.
    std::vector<double> variance(int layer, int channel) const;
    std::vector<double> scattered_variance(int channel) const;

    /// sqrt(mean variance) / mean of what scattered, over the pixels of `seen` and all channels.
    /// Infinite before there are two batches, or if nothing scattered.
    double noise(const std::vector<bool>& seen) const;

    /// Writes the sums under `file`, whole or not at all; `key` says what of. Throws OutputError.
    void save(const std::filesystem::path& file, const std::string& key, double seconds) const;
    /// Reads them back, and the seconds. Throws InputError for a damaged file or another key.
    double load(const std::filesystem::path& file, const std::string& key);

private:
    // Layers, and as the last one what scattered.
    static constexpr int kSums = (kLayers + 1) * kChannels;

    std::vector<double> over_batches(const std::vector<double>& sum) const;
    std::vector<double> variance_of(const std::vector<double>& sum,
                                    const std::vector<double>& squares) const;

    std::size_t pixels_;
    std::uint64_t batches_ = 0;
    std::vector<std::vector<double>> sums_, squares_;  // [layer * kChannels + channel][pixel]
};

}  // namespace tallow::reference
