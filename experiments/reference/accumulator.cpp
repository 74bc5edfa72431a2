// SPDX-License-Identifier: Apache-2.0
#include "experiments/reference/accumulator.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <span>

#include "common/base/errors.h"
#include "common/base/output_file.h"
#include "common/base/vec.h"

namespace tallow::reference {
namespace {

constexpr char kMagic[] = "tallow reference checkpoint 1\n";

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
    return std::as_bytes(std::span(&value, 1));
}

/// A stream that is read to its end, or else the file is refused.
class Reader {
public:
    explicit Reader(const std::filesystem::path& file) : file_(file), in_(file, std::ios::binary) {
        if (!in_) fail("cannot be read");
    }
    void read(std::span<std::byte> bytes) {
        if (!in_.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size())))
            fail("is cut short");
    }
    template <class T>
    T value() {
        T value{};
        read(std::as_writable_bytes(std::span(&value, 1)));
        return value;
    }
    void expect_end() {
        if (in_.peek() != std::ifstream::traits_type::eof()) fail("is longer than it should be");
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(fmt::format("{}: checkpoint {}; remove it, or run without --resume",
                                     file_.string(), what));
    }

private:
    std::filesystem::path file_;
    std::ifstream in_;
};

}  // namespace

Accumulator::Accumulator(std::size_t pixels)
    : pixels_(pixels),
      sums_(kSums, std::vector<double>(pixels)),
      squares_(kSums, std::vector<double>(pixels)) {}

void Accumulator::add(const Film& batch) {
    ++batches_;
    const auto put = [&](int sum, std::size_t pixel, double value) {
        sums_[std::size_t(sum)][pixel] += value;
        squares_[std::size_t(sum)][pixel] += value * value;
    };
    for (int channel = 0; channel < kChannels; ++channel)
        for (std::size_t pixel = 0; pixel < pixels_; ++pixel) {
            double scattered = 0;
            for (int layer = 0; layer < kLayers; ++layer) {
                const auto value = double(batch.of(layer, channel)[pixel]);
                put(layer * kChannels + channel, pixel, value);
                if (layer != mirror) scattered += value;
            }
            put(kLayers * kChannels + channel, pixel, scattered);
        }
}

std::vector<double> Accumulator::over_batches(const std::vector<double>& sum) const {
    std::vector<double> mean(sum);
    for (double& value : mean) value /= double(std::max<std::uint64_t>(1, batches_));
    return mean;
}

std::vector<double> Accumulator::variance_of(const std::vector<double>& sum,
                                             const std::vector<double>& squares) const {
    std::vector<double> variance(pixels_, 0.0);
    if (batches_ < 2) return variance;
    const auto n = double(batches_);
    for (std::size_t i = 0; i < pixels_; ++i) {
        const double mean = sum[i] / n;
        variance[i] = std::max(0.0, squares[i] / n - mean * mean) / (n - 1);
    }
    return variance;
}

std::vector<double> Accumulator::mean(int layer, int channel) const {
    return over_batches(sums_[std::size_t(layer * kChannels + channel)]);
}
std::vector<double> Accumulator::scattered(int channel) const { return mean(kLayers, channel); }

std::vector<double> Accumulator::variance(int layer, int channel) const {
    const auto i = std::size_t(layer * kChannels + channel);
    return variance_of(sums_[i], squares_[i]);
}
std::vector<double> Accumulator::scattered_variance(int channel) const {
    return variance(kLayers, channel);
}

double Accumulator::noise(const std::vector<bool>& seen) const {
    double mean = 0, variance_sum = 0, count = 0;
    for (int channel = 0; channel < kChannels; ++channel) {
        const std::vector<double> means = scattered(channel);
        const std::vector<double> variances = scattered_variance(channel);
        for (std::size_t i = 0; i < pixels_; ++i)
            if (seen[i]) mean += means[i], variance_sum += variances[i], ++count;
    }
    if (batches_ < 2 || !(mean > 0)) return double(kInfinity);
    return std::sqrt(variance_sum / count) / (mean / count);
}

void Accumulator::save(const std::filesystem::path& file, const std::string& key,
                       double seconds) const {
    OutputFile out(file);
    out.write(std::string_view(kMagic));
    out.write(bytes_of(std::uint64_t(key.size())));
    out.write(key);
    out.write(bytes_of(seconds));
    out.write(bytes_of(batches_));
    for (const auto* table : {&sums_, &squares_})
        for (const std::vector<double>& values : *table)
            out.write(std::as_bytes(std::span(values)));
    out.commit();
}

double Accumulator::load(const std::filesystem::path& file, const std::string& key) {
    Reader in(file);
    std::string magic(sizeof(kMagic) - 1, ' ');
    in.read(std::as_writable_bytes(std::span(magic)));
    if (magic != kMagic) in.fail("is of another format");
    if (in.value<std::uint64_t>() != key.size()) in.fail("is of another run");
    std::string found(key.size(), ' ');
    in.read(std::as_writable_bytes(std::span(found)));
    if (found != key) in.fail("is of another run");
    const auto seconds = in.value<double>();
    const auto batches = in.value<std::uint64_t>();
    for (auto* table : {&sums_, &squares_})
        for (std::vector<double>& values : *table)
            in.read(std::as_writable_bytes(std::span(values)));
    in.expect_end();
    for (const auto* table : {&sums_, &squares_})
        for (const std::vector<double>& values : *table)
            for (double value : values)
                if (!std::isfinite(value)) in.fail("holds numbers that are not finite");
    batches_ = batches;
    return seconds;
}

}  // namespace tallow::reference
