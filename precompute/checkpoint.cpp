// SPDX-License-Identifier: Apache-2.0
// Finished irradiance <-> an append-only file. Records are copied into memory when they are made
// and appended every few seconds, so that short runs never touch the disk.
#include "precompute/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <optional>
#include <string_view>

#include "common/base/errors.h"
#include "common/cloud/cache_io.h"
#include "common/cloud/fingerprint_text.h"
#include "common/cloud/section_table.h"

namespace tallow {
namespace {

constexpr std::string_view kMagic = "TALLOWP3";

struct RecordHeader {
    std::uint32_t kind, body;
    std::uint64_t begin, end, groups, checksum;
};
static_assert(sizeof(RecordHeader) == 40);

std::uint64_t checksum_of(RecordHeader header, std::string_view payload) {
    header.checksum = cache_checksum(std::as_bytes(std::span(payload)));
    return cache_checksum(std::as_bytes(std::span(&header, 1)));
}

template <class T>
void append(std::string& bytes, std::span<const T> items) {
    bytes.append(reinterpret_cast<const char*>(items.data()), items.size_bytes());
}

/// Takes items from the front of a text; nothing if it is too short.
class Reader {
public:
    explicit Reader(std::string_view bytes) : bytes_(bytes) {}

    std::optional<std::string_view> take(std::uint64_t count) {
        if (count > bytes_.size()) return std::nullopt;
        const std::string_view front = bytes_.substr(0, count);
        bytes_.remove_prefix(count);
        return front;
    }
    template <class T>
    std::optional<T> take_value() {
        const auto bytes = take(sizeof(T));
        if (!bytes) return std::nullopt;
        T value;
        std::memcpy(&value, bytes->data(), sizeof(T));
        return value;
    }

    std::size_t left() const { return bytes_.size(); }

private:
    std::string_view bytes_;
};

std::string payload_of(std::size_t begin, std::size_t end,
                       const std::vector<GroupIrradiance>& groups) {
    std::string payload;
    for (const GroupIrradiance& group : groups) {
        append(payload, std::span(group.E_t).subspan(begin, end - begin));
        append(payload, std::span(group.w_i).subspan(begin, end - begin));
    }
    return payload;
}

std::string header_of(const Fingerprint& fingerprint) {
    const std::string text = encode_fingerprint(fingerprint);
    const std::uint64_t length = text.size(),
                        checksum = cache_checksum(std::as_bytes(std::span(text)));
    std::string header(kMagic);
    append(header, std::span(&length, 1));
    header += text;
    append(header, std::span(&checksum, 1));
    return header;
}

std::optional<Fingerprint> take_fingerprint(Reader& reader) {
    const auto magic = reader.take(kMagic.size());
    if (!magic || *magic != kMagic) return std::nullopt;
    const auto length = reader.take_value<std::uint64_t>();
    const auto text = length ? reader.take(*length) : std::nullopt;
    const auto checksum = reader.take_value<std::uint64_t>();
    if (!text || !checksum || *checksum != cache_checksum(std::as_bytes(std::span(*text))))
        return std::nullopt;
    return decode_fingerprint(*text);
}

// All pairs count, those of the sampling too: results of two ways of sampling do not mix.
void require_same_work(const std::filesystem::path& file, const Fingerprint& made_from,
                       const Fingerprint& now) {
    for (std::size_t i = 0; i < std::max(made_from.size(), now.size()); ++i) {
        const auto text = [i](const Fingerprint& f) {
            return i < f.size() ? f[i].first + " = " + f[i].second : std::string("nothing");
        };
        if (text(made_from) == text(now)) continue;
        throw InputError(
            fmt::format("{}: checkpoint made from {}, but the scene has {}; run without --resume "
                        "to begin anew",
                        file.string(), text(made_from), text(now)));
    }
}

}  // namespace

Checkpoint::Checkpoint(std::filesystem::path file, Fingerprint fingerprint, Options options)
    : file_(std::move(file)),
      fingerprint_(std::move(fingerprint)),
      options_(options),
      last_write_(std::chrono::steady_clock::now()) {
    if (options_.resume) read();
}

Checkpoint::~Checkpoint() {
    try {
        if (!finished_) write_pending();
    } catch (const OutputError&) {
        // The run has failed already, and says why itself.
    }
}

void Checkpoint::read() {
    std::ifstream input(file_, std::ios::binary);
    if (!input) return;
    const std::string bytes(std::istreambuf_iterator<char>(input), {});
    Reader reader(bytes);
    const auto made_from = take_fingerprint(reader);
    if (!made_from)
        throw InputError(fmt::format(
            "{}: expected a checkpoint of this version; run without --resume to begin anew",
            file_.string()));
    require_same_work(file_, *made_from, fingerprint_);
    good_bytes_ = bytes.size() - reader.left();
    while (const auto header = reader.take_value<RecordHeader>()) {
        constexpr std::uint64_t kSampleBytes = sizeof(Rgb) + sizeof(Vec3);
        if (header->end <= header->begin || header->groups == 0 ||
            header->end - header->begin > bytes.size() / kSampleBytes / header->groups)
            return;
        const auto payload =
            reader.take((header->end - header->begin) * header->groups * kSampleBytes);
        if (!payload || checksum_of(*header, *payload) != header->checksum) return;
        restorable_[{header->kind, header->body, header->begin, header->end}] = *payload;
        good_bytes_ = bytes.size() - reader.left();
    }
}

bool Checkpoint::restore(Stage stage, std::uint32_t body, std::size_t begin, std::size_t end,
                         std::vector<GroupIrradiance>& groups) {
    const auto found = restorable_.find({std::uint32_t(stage), body, begin, end});
    if (found == restorable_.end()) return false;
    const std::size_t count = end - begin;
    if (found->second.size() != groups.size() * count * (sizeof(Rgb) + sizeof(Vec3))) return false;
    const char* next = found->second.data();
    for (GroupIrradiance& group : groups) {
        std::memcpy(&group.E_t[begin], next, count * sizeof(Rgb));
        next += count * sizeof(Rgb);
        std::memcpy(&group.w_i[begin], next, count * sizeof(Vec3));
        next += count * sizeof(Vec3);
    }
    restorable_.erase(found);
    restored_ += count;
    return true;
}

void Checkpoint::keep(Stage stage, std::uint32_t body, std::size_t begin, std::size_t end,
                      const std::vector<GroupIrradiance>& groups) {
    const std::string payload = payload_of(begin, end, groups);
    RecordHeader header{std::uint32_t(stage), body, begin, end, groups.size(), 0};
    header.checksum = checksum_of(header, payload);
    append(pending_, std::span<const RecordHeader>(&header, 1));
    pending_ += payload;
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - last_write_;
    if (since.count() >= options_.seconds || pending_.size() > options_.most_pending)
        write_pending();
}

void Checkpoint::write_pending() {
    if (pending_.empty()) return;
    if (!stream_.is_open()) open();
    stream_ << pending_ << std::flush;
    if (!stream_)
        throw OutputError(
            fmt::format("{}: cannot be written: {}", file_.string(), std::strerror(errno)));
    pending_.clear();
    last_write_ = std::chrono::steady_clock::now();
}

// Goes on behind what was good in the file, or begins it.
void Checkpoint::open() {
    std::error_code failure;
    if (good_bytes_ > 0) std::filesystem::resize_file(file_, good_bytes_, failure);
    stream_.open(file_, std::ios::binary | (good_bytes_ > 0 ? std::ios::app : std::ios::trunc));
    if (good_bytes_ == 0) stream_ << header_of(fingerprint_);
    if (failure) stream_.setstate(std::ios::failbit);
}

void Checkpoint::finish() {
    finished_ = true;
    pending_.clear();
    stream_.close();
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
}

}  // namespace tallow
