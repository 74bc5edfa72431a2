// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace tallow {

/// Listens as tev does, on a port of its own, to one client, and keeps the images that it is sent.
/// Packets are taken apart as tev's README and its clients document them. Whatever is not as
/// documented throws in images().
class FakeTev {
public:
    struct SentImage {
        int width = 0, height = 0, updates = 0;
        std::map<std::string, std::vector<float>> channels;  // [y * width + x]
    };

    FakeTev() : listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        auto* generic = reinterpret_cast<sockaddr*>(&address);
        if (::bind(listener_, generic, size) != 0 || ::listen(listener_, 1) != 0 ||
            ::getsockname(listener_, generic, &size) != 0)
            throw std::runtime_error("the fake tev cannot listen");
        port_ = ntohs(address.sin_port);
        thread_ = std::thread([this] { receive(); });
    }
    ~FakeTev() {
        if (thread_.joinable()) thread_.join();
        ::close(listener_);
    }

    int port() const { return port_; }

    /// Once the client has hung up.
    std::map<std::string, SentImage> images() {
        thread_.join();
        std::map<std::string, SentImage> images;
        std::size_t at = 0;
        while (at < bytes_.size()) {
            std::uint32_t length = 0;
            require(bytes_.size() - at >= sizeof length, "a packet's length");
            std::memcpy(&length, bytes_.data() + at, sizeof length);
            require(length >= 6 && length <= bytes_.size() - at, "a whole packet");
            take_packet(bytes_.substr(at + 4, length - 4), images);
            at += length;
        }
        return images;
    }

private:
    struct Reader {
        const std::string& bytes;
        std::size_t at = 0;

        template <class T>
        T number() {
            T value;
            require(bytes.size() - at >= sizeof value, "a number");
            std::memcpy(&value, bytes.data() + at, sizeof value);
            at += sizeof value;
            return value;
        }
        std::string text() {
            const std::size_t end = bytes.find('\0', at);
            require(end != std::string::npos, "a text's end");
            std::string value = bytes.substr(at, end - at);
            at = end + 1;
            return value;
        }
        std::vector<std::string> texts() {
            std::vector<std::string> values(std::size_t(number<std::int32_t>()));
            for (std::string& value : values) value = text();
            return values;
        }
    };

    static void require(bool condition, const char* what) {
        if (!condition) throw std::runtime_error(std::string("expected ") + what);
    }

    void receive() {
        const int client = ::accept(listener_, nullptr, nullptr);
        char buffer[65536];
        for (ssize_t n; (n = ::read(client, buffer, sizeof buffer)) > 0;)
            bytes_.append(buffer, std::size_t(n));
        ::close(client);
    }

    static void take_packet(const std::string& packet, std::map<std::string, SentImage>& images) {
        Reader reader{packet};
        const auto operation = reader.number<std::uint8_t>();
        require(reader.number<std::uint8_t>() <= 1, "a flag");
        const std::string name = reader.text();
        if (operation == 4) {
            SentImage& image = images[name] = {};
            image.width = reader.number<std::int32_t>();
            image.height = reader.number<std::int32_t>();
            const std::size_t pixels = std::size_t(image.width) * std::size_t(image.height);
            for (const std::string& channel : reader.texts())
                image.channels[channel].resize(pixels);
        } else {
            require(operation == 6, "operation 4 or 6");
            update(reader, images.at(name));
        }
        require(reader.at == packet.size(), "nothing after the payload");
    }

    static void update(Reader& reader, SentImage& image) {
        const std::vector<std::string> channels = reader.texts();
        const auto x = reader.number<std::int32_t>(), y = reader.number<std::int32_t>();
        const auto width = reader.number<std::int32_t>(), height = reader.number<std::int32_t>();
        require(x >= 0 && y >= 0 && x + width <= image.width && y + height <= image.height,
                "a region inside the image");
        std::vector<std::int64_t> offsets, strides;
        for (std::size_t c = 0; c < channels.size(); ++c)
            offsets.push_back(reader.number<std::int64_t>());
        for (std::size_t c = 0; c < channels.size(); ++c)
            strides.push_back(reader.number<std::int64_t>());
        std::vector<float> values((reader.bytes.size() - reader.at) / sizeof(float));
        for (float& value : values) value = reader.number<float>();
        for (std::size_t c = 0; c < channels.size(); ++c)
            for (int i = 0; i < width * height; ++i)
                image.channels.at(
                    channels[c])[std::size_t((y + i / width) * image.width + x + i % width)] =
                    values.at(std::size_t(offsets[c] + i * strides[c]));
        ++image.updates;
    }

    int listener_, port_ = 0;
    std::string bytes_;
    std::thread thread_;
};

}  // namespace tallow
