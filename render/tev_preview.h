// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "common/image/image.h"

namespace tallow {

/// Where a tev listens.
struct TevAddress {
    std::string host = "127.0.0.1";
    std::string port = "14158";
};

/// Reads "HOST:PORT", "HOST" or ":PORT"; what is missing, or all of an empty text, is tev's
/// default. An IPv6 address stands in brackets: "[::1]:14158". Throws UsageError.
TevAddress parse_tev_address(const std::string& text);

/// Shows images in a running tev while they are made, over its TCP protocol. Each packet is
///
///     u32 bytes of the packet, these four included | u8 operation | payload
///     create (4)   u8 grab focus, name, i32 width, i32 height, i32 n, n channel names
///     update (6)   u8 grab focus, name, i32 n, n channel names, i32 x, y, width, height,
///                  n i64 offsets and n i64 strides in floats, the floats
///
/// little endian, texts ended by a zero byte; tev answers nothing. A picture must not fail because
/// nobody looks at it: whatever goes wrong ends the preview, and problem() says what it was.
///
/// Source   the README of tev (github.com/Tom94/tev), "Over the Network"; the layout of payloads as
///          clients in several languages send it.
class TevPreview {
public:
    explicit TevPreview(const TevAddress& address);
    ~TevPreview();
    TevPreview(const TevPreview&) = delete;
    TevPreview& operator=(const TevPreview&) = delete;

    /// A new image, black, with the size and the channels of `image`, under a name; one that has it
    /// is replaced.
    void create(const std::string& name, const Image& image);
    /// Fills the data window of `image` into the image of that name.
    void update(const std::string& name, const Image& image);

    /// Why nothing is sent any more; empty if all is well.
    const std::string& problem() const { return problem_; }

private:
    void connect();
    void send(std::string packet);
    void fail(const std::string& what, int error);

    TevAddress address_;
    int socket_ = -1;
    std::string problem_;
};

}  // namespace tallow
