// SPDX-License-Identifier: Apache-2.0
//
// A triangle soup in, one without triangles of zero area out (repair step 2). With coincident
// vertices joined, such a triangle has its middle vertex m on its longest edge ab: it fills the gap
// between triangles over ab on one side and over am and mb on the other. Splitting the former at m
// closes the gap without it. Longest first: what a split makes flat is shorter.

#include <algorithm>
#include <array>
#include <queue>
#include <unordered_map>

#include "common/geometry/mesh_repair_steps.h"

namespace tallow {

namespace {

class FlatRemover {
public:
    explicit FlatRemover(TriangleSoup& soup)
        : soup_(soup), alive_(soup.triangles.size(), true), splits_left_(4 * alive_.size() + 64) {}

    /// Returns how many flat triangles there were.
    std::size_t run() {
        for (std::uint32_t t = 0; t < alive_.size(); ++t) enqueue_if_flat(t);
        const std::size_t count = queue_.size();
        if (count == 0) return 0;
        for (std::uint32_t t = 0; t < alive_.size(); ++t) register_edges(t);
        while (!queue_.empty()) {
            const std::uint32_t t = queue_.top().second;
            queue_.pop();
            if (alive_[t]) remove(t);
        }
        keep_triangles(soup_, [&](std::size_t t) { return alive_[t]; });
        return count;
    }

private:
    DVec3 point(std::uint32_t vertex) const { return soup_.vertices[vertex]; }

    double length(const Triangle& t, std::size_t corner) const {
        return glm::distance(point(t[corner]), point(t[(corner + 1) % 3]));
    }

    /// Corner at which the longest edge begins.
    std::size_t longest(const Triangle& t) const {
        const std::array<double, 3> l = {length(t, 0), length(t, 1), length(t, 2)};
        return static_cast<std::size_t>(std::max_element(l.begin(), l.end()) - l.begin());
    }

    /// From whichever corner it is measured: the sides' rounding differs.
    bool has_area(const Triangle& t) const {
        for (std::size_t c = 0; c < 3; ++c) {
            const DVec3 p = point(t[c]);
            const DVec3 n = glm::cross(point(t[(c + 1) % 3]) - p, point(t[(c + 2) % 3]) - p);
            if (!(glm::length(n) > 0)) return false;
        }
        return true;
    }

    static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
        return a < b ? (std::uint64_t{a} << 32 | b) : (std::uint64_t{b} << 32 | a);
    }

    void enqueue_if_flat(std::uint32_t index) {
        const Triangle& t = soup_.triangles[index];
        if (!has_area(t)) queue_.emplace(length(t, longest(t)), index);
    }

    void register_edges(std::uint32_t index) {
        const Triangle& t = soup_.triangles[index];
        for (std::size_t c = 0; c < 3; ++c) users_[key(t[c], t[(c + 1) % 3])].push_back(index);
    }

    void remove(std::uint32_t index) {
        alive_[index] = false;
        const Triangle t = soup_.triangles[index];
        const std::size_t c = longest(t);
        const std::uint64_t edge = key(t[c], t[(c + 1) % 3]);
        const std::uint32_t middle = t[(c + 2) % 3];
        const std::vector<std::uint32_t> users = users_[edge];
        for (const std::uint32_t user : users)
            if (alive_[user] && splits_left_ > 0) split(user, edge, middle);
    }

    /// Splits a triangle at a vertex on one of its edges; its twin (no side left) vanishes.
    void split(std::uint32_t index, std::uint64_t edge, std::uint32_t middle) {
        const Triangle t = soup_.triangles[index];
        std::size_t c = 0;
        while (key(t[c], t[(c + 1) % 3]) != edge) ++c;
        const std::uint32_t a = t[c], b = t[(c + 1) % 3], apex = t[(c + 2) % 3];
        alive_[index] = false;
        --splits_left_;
        if (apex == middle) return;
        add({a, middle, apex}, index);
        add({middle, b, apex}, index);
    }

    void add(const Triangle& t, std::uint32_t part_of) {
        const auto index = static_cast<std::uint32_t>(soup_.triangles.size());
        soup_.triangles.push_back(t);
        if (!soup_.polygon.empty()) soup_.polygon.push_back(soup_.polygon[part_of]);
        alive_.push_back(true);
        register_edges(index);
        enqueue_if_flat(index);
    }

    TriangleSoup& soup_;
    std::vector<bool> alive_;  // [triangle]
    // Many flat triangles along one line split each other again and again; four splits a triangle
    // are far more than files need (there, most need one), and keep hostile ones from growing.
    std::size_t splits_left_;
    std::priority_queue<std::pair<double, std::uint32_t>> queue_;  // longest edge, flat triangle
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> users_;  // [edge] triangles
};

}  // namespace

void remove_flat_triangles(TriangleSoup& soup, RepairReport& report) {
    report.degenerate_faces += FlatRemover(soup).run();
}

}  // namespace tallow
