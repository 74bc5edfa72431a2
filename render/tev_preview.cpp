// SPDX-License-Identifier: Apache-2.0
// Images -> packets -> a socket.
#include "render/tev_preview.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <memory>

#include "common/base/errors.h"
#include "common/base/parse_whole.h"

namespace tallow {
namespace {

constexpr int kConnectMilliseconds = 2000, kSendSeconds = 5;  // chosen: a person still waits

enum class Operation : std::uint8_t { create = 4, update = 6 };

static_assert(std::endian::native == std::endian::little, "packets hold numbers as memory does");

class Packet {
public:
    explicit Packet(Operation operation) {
        put(std::uint32_t(0));  // the length, known at the end
        put(operation);
        put(std::uint8_t(0));  // no focus: the user may be looking at something else
    }

    template <class T>
    void put(T number) {
        bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
    }
    void put_text(const std::string& text) { bytes_.append(text.c_str(), text.size() + 1); }
    void put_names(const Image& image) {
        put(std::int32_t(image.channels.size()));
        for (const Channel& channel : image.channels) put_text(channel.name);
    }
    void put_values(const std::vector<float>& values) {
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    }

    std::string finish() {
        const auto size = std::uint32_t(bytes_.size());
        std::memcpy(bytes_.data(), &size, sizeof size);
        return std::move(bytes_);
    }

private:
    std::string bytes_;
};

/// Returns 0, or the error of a connection that did not come about in time.
int connect_in_time(int socket, const addrinfo& to) {
    const int flags = ::fcntl(socket, F_GETFL);
    ::fcntl(socket, F_SETFL, flags | O_NONBLOCK);
    if (::connect(socket, to.ai_addr, to.ai_addrlen) != 0) {
        if (errno != EINPROGRESS) return errno;
        pollfd waiting{socket, POLLOUT, 0};
        if (::poll(&waiting, 1, kConnectMilliseconds) != 1) return ETIMEDOUT;
        int error = 0;
        socklen_t size = sizeof error;
        ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
        if (error != 0) return error;
    }
    ::fcntl(socket, F_SETFL, flags);
    const timeval patience{kSendSeconds, 0};
    ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    return 0;
}

}  // namespace

TevAddress parse_tev_address(const std::string& text) {
    const auto refuse = [&] {
        return UsageError(fmt::format("--preview: expected HOST:PORT, got '{}'", text));
    };
    TevAddress address;
    std::size_t colon = text.rfind(':');
    std::string host = text.substr(0, colon);
    if (text.starts_with('[')) {
        const std::size_t end = text.find(']');
        if (end == std::string::npos) throw refuse();
        host = text.substr(1, end - 1);
        if (end + 1 < text.size() && text[end + 1] != ':') throw refuse();
        colon = end + 1 < text.size() ? end + 1 : std::string::npos;
    }
    if (host.find_first_of("/ []") != std::string::npos) throw refuse();
    if (!host.empty()) address.host = host;
    if (colon == std::string::npos) return address;
    const std::string port = text.substr(colon + 1);
    const auto number = parse_whole<int>(port);
    if (!number || *number < 1 || *number > 65535) throw refuse();
    address.port = port;
    return address;
}

TevPreview::TevPreview(const TevAddress& address) : address_(address) { connect(); }

TevPreview::~TevPreview() {
    if (socket_ >= 0) ::close(socket_);
}

void TevPreview::connect() {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int code = ::getaddrinfo(address_.host.c_str(), address_.port.c_str(), &hints, &found);
    if (code != 0) {
        problem_ = fmt::format("no preview: {}:{}: {}", address_.host, address_.port,
                               ::gai_strerror(code));
        return;
    }
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> all(found, &::freeaddrinfo);
    int error = 0;
    for (const addrinfo* to = found; to != nullptr; to = to->ai_next) {
        socket_ = ::socket(to->ai_family, to->ai_socktype | SOCK_CLOEXEC, to->ai_protocol);
        if (socket_ < 0) {
            error = errno;
            continue;
        }
        error = connect_in_time(socket_, *to);
        if (error == 0) return;
        ::close(socket_);
        socket_ = -1;
    }
    fail("no tev listens", error);
}

void TevPreview::fail(const std::string& what, int error) {
    problem_ = fmt::format("no preview: {} at {}:{}: {}", what, address_.host, address_.port,
                           std::strerror(error));
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
}

void TevPreview::send(std::string packet) {
    if (socket_ < 0) return;
    for (std::size_t sent = 0; sent < packet.size();) {
        const ssize_t n = ::send(socket_, packet.data() + sent, packet.size() - sent, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return fail("tev stopped listening", n < 0 ? errno : EPIPE);
        sent += std::size_t(n);
    }
}

void TevPreview::create(const std::string& name, const Image& image) {
    Packet packet(Operation::create);
    packet.put_text(name);
    packet.put(std::int32_t(image.width));
    packet.put(std::int32_t(image.height));
    packet.put_names(image);
    send(packet.finish());
}

// One channel after the other.
void TevPreview::update(const std::string& name, const Image& image) {
    Packet packet(Operation::update);
    packet.put_text(name);
    packet.put_names(image);
    for (const int number : {image.x0, image.y0, image.crop_width, image.crop_height})
        packet.put(std::int32_t(number));
    const std::int64_t pixels = std::int64_t(image.crop_width) * image.crop_height;
    for (std::size_t c = 0; c < image.channels.size(); ++c) packet.put(std::int64_t(c) * pixels);
    for (std::size_t c = 0; c < image.channels.size(); ++c) packet.put(std::int64_t(1));
    for (const Channel& channel : image.channels) packet.put_values(channel.values);
    send(packet.finish());
}

}  // namespace tallow
