// SPDX-License-Identifier: Apache-2.0
#include "material/swatch.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "common/cloud/cache_io.h"
#include "common/image/exr_io.h"
#include "common/image/png_io.h"
#include "material/swatch_scene.h"
#include "precompute/precompute.h"
#include "render/render_image.h"

namespace tallow {
namespace {

// Coarser than automatic spacing may ask for: finer details are below half a pixel of a swatch, and
// a column takes seconds.
constexpr float kFinestSpacing = 0.1f;  // mm
constexpr float kExtent = 20;           // mm, of the block and the ball

/// A file that is removed at the end, however that comes.
class TemporaryFile {
public:
    explicit TemporaryFile(std::filesystem::path path) : path_(std::move(path)) {}
    ~TemporaryFile() {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

std::filesystem::path cache_beside(const std::filesystem::path& output) {
    return output.string() + fmt::format(".{}.tallow", getpid());
}

Image render_column(const SubsurfaceMaterial& material, const std::filesystem::path& output,
                    Progress& progress, Stats& stats) {
    const Scene scene = swatch_scene(material);
    const TemporaryFile cache_file(cache_beside(output));
    PrecomputeOptions wish;
    wish.sampling.spacing = std::max(
        kFinestSpacing, automatic_spacing(material.medium, scene.settings.tolerance, kExtent));
    precompute(scene, wish, cache_file.path(), progress, stats);

    const MappedCache cache(cache_file.path());
    const SceneGeometry geometry = load_geometry(scene, stats);
    const PreparedScene world(scene, geometry, cache.view(), {scene.settings.tolerance}, {}, stats);
    const Camera& camera = scene.cameras.front();
    return render_image(world, camera, {whole_image(camera), scene.settings.samples}, progress,
                        stats);
}

void copy_column(const Image& column, int index, Image& row) {
    for (Channel& channel : row.channels) {
        const std::vector<float>& source = *column.find_channel(channel.name);
        for (int y = 0; y < column.height; ++y)
            std::copy_n(source.begin() + std::ptrdiff_t(y) * column.width, column.width,
                        channel.values.begin() + std::ptrdiff_t(y) * row.width +
                            std::ptrdiff_t(index) * column.width);
    }
}

}  // namespace

Image render_swatches(const std::vector<SubsurfaceMaterial>& materials,
                      const std::filesystem::path& output, Progress& progress, Stats& stats) {
    Image row = make_image(kSwatchWidth * int(materials.size()), kSwatchHeight);
    for (const char* name : {"R", "G", "B", "A"}) row.add_channel(name);
    for (std::size_t i = 0; i < materials.size(); ++i)
        copy_column(render_column(materials[i], output, progress, stats), int(i), row);
    return row;
}

void write_picture(const std::filesystem::path& file, const Image& image) {
    if (file.extension() == ".exr")
        write_exr(file, image);
    else
        write_png(file, image);
}

}  // namespace tallow
