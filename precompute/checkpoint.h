// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "common/cloud/cache_format.h"
#include "precompute/gather_irradiance.h"

namespace tallow {

/// Irradiance that is done, kept in a file while pass one runs, so that after an interruption,
/// however rude, a run with `resume` computes only the rest. What is restored are the bits that
/// were computed, so that the result is the same as of a run that was never interrupted.
///
///     file      header | record ...
///     header    "TALLOWP3", u64 length, the fingerprint's text, u64 its XXH3
///     record    u32 kind, u32 body, u64 begin, u64 end, u64 groups, u64 XXH3 of all of it,
///               then for each group E_t and w_i of [begin, end): of samples, or
///               of patches of them for indirect light
///
/// The first record that is damaged or cut short ends the file: what a crash left half-written is
/// computed again.
class Checkpoint {
public:
    struct Options {
        bool resume = false;
        /// Seconds of work between two writes; a short run writes nothing.
        double seconds = 5;
        /// Bytes that wait in memory at most; chosen: a million samples of one light group.
        std::size_t most_pending = std::size_t(1) << 25;
    };
    /// What a record is about: a stage of the work on one body.
    enum class Stage : std::uint32_t { direct = 1, surfaces = 2, bodies = 3 /* + round */ };

    /// `fingerprint` names everything that the irradiance depends on, "sampling." too.
    ///
    /// Throws   InputError if `resume` is asked for and the file is no checkpoint or was made from
    ///          something else (both values are named).
    Checkpoint(std::filesystem::path file, Fingerprint fingerprint, Options options);
    /// Writes what is not written yet, unless finish() was called.
    ~Checkpoint();
    Checkpoint(const Checkpoint&) = delete;
    Checkpoint& operator=(const Checkpoint&) = delete;

    /// Copies the samples [begin, end) of a stage into `groups` if the file had them.
    bool restore(Stage stage, std::uint32_t body, std::size_t begin, std::size_t end,
                 std::vector<GroupIrradiance>& groups);
    /// Keeps them, now or with the next write.
    void keep(Stage stage, std::uint32_t body, std::size_t begin, std::size_t end,
              const std::vector<GroupIrradiance>& groups);

    /// Writes now what is not written yet. Throws OutputError.
    void write_pending();

    /// The work is done and safe elsewhere: removes the file.
    void finish();

    std::size_t restored_samples() const { return restored_; }
    const std::filesystem::path& file() const { return file_; }

private:
    using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint64_t, std::uint64_t>;

    void read();
    void open();

    std::filesystem::path file_;
    Fingerprint fingerprint_;
    Options options_;
    std::map<Key, std::string> restorable_;  // payloads
    std::string pending_;                    // records that are not in the file yet
    std::ofstream stream_;
    std::chrono::steady_clock::time_point last_write_;
    std::size_t good_bytes_ = 0;  // of an earlier run's file
    std::size_t restored_ = 0;
    bool finished_ = false;
};

}  // namespace tallow
