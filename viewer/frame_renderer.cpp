// SPDX-License-Identifier: Apache-2.0
// Wishes -> frames.
#include "viewer/frame_renderer.h"

#include <algorithm>
#include <utility>

#include "common/base/errors.h"
#include "common/base/parallel.h"

namespace tallow {
namespace {

// What a draft may take. Chosen: twenty frames a second, with some time left for the window.
constexpr double kDraftMilliseconds = 45;

constexpr float kScales[] = {1, 1.25f, 1.5f, 1.75f, 2, 2.5f, 3, 4, 6, 8};
constexpr float kFirstScale = 4;  // before a draft has been timed

}  // namespace

FrameRenderer::FrameRenderer(std::function<std::unique_ptr<ViewedScene>()> load, Wish wish,
                             int threads, std::function<void()> on_news)
    : load_(std::move(load)),
      threads_(threads),
      on_news_(std::move(on_news)),
      wish_(std::move(wish)),
      wish_time_(std::chrono::steady_clock::now()),
      current_(wish_),
      thread_([this] { run(); }) {}

FrameRenderer::~FrameRenderer() {
    {
        const std::lock_guard lock(mutex_);
        ends_ = true;
        stop_.request_stop();
    }
    wished_.notify_one();
    thread_.join();
}

void FrameRenderer::want(Wish wish) {
    {
        const std::lock_guard lock(mutex_);
        wish_ = std::move(wish);
        wish_time_ = std::chrono::steady_clock::now();
        is_new_ = true;
        stop_.request_stop();
    }
    wished_.notify_one();
}

FrameRenderer::News FrameRenderer::latest() const {
    const std::lock_guard lock(mutex_);
    return news_;
}

FrameRenderer::Status FrameRenderer::status() const {
    const std::lock_guard lock(mutex_);
    return status_;
}

std::string FrameRenderer::cache_name() const {
    const std::lock_guard lock(mutex_);
    return cache_name_;
}

void FrameRenderer::rethrow_failure() const {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
}

std::optional<Vec3> FrameRenderer::point_under(const Camera& camera, Vec2 pixel) const {
    const RayScene* rays = nullptr;
    {
        const std::lock_guard lock(mutex_);
        rays = rays_;
    }
    if (rays == nullptr) return std::nullopt;
    const std::optional<Hit> hit = rays->intersect(camera_ray(camera, pixel.x, pixel.y));
    return hit ? std::optional(hit->position) : std::nullopt;
}

void FrameRenderer::run() {
    try {
        const ThreadLimit limit(threads_);
        work();
    } catch (...) {
        const std::lock_guard lock(mutex_);
        failure_ = std::current_exception();
    }
    on_news_();
}

void FrameRenderer::work() {
    scene_ = load_();
    {
        const std::lock_guard lock(mutex_);
        rays_ = &scene_->world().rays();
        cache_name_ = scene_->cache_name();
    }
    while (take_wish()) {
        try {
            prepare();
            draw();
        } catch (const InputError& problem) {
            const std::lock_guard lock(mutex_);
            status_ = {Stage::resting, problem.what()};
        }
        on_news_();
    }
}

// Waits for a wish; returns false at the end.
bool FrameRenderer::take_wish() {
    std::unique_lock lock(mutex_);
    wished_.wait(lock, [&] { return is_new_ || ends_; });
    if (ends_) return false;
    is_new_ = false;
    stop_ = {};
    stopped_ = stop_.get_token();
    current_ = wish_;
    current_time_ = wish_time_;
    status_.problem.clear();
    return true;
}

// Whatever cannot be had leaves the world as it was.
void FrameRenderer::prepare() {
    if (current_.scene == scene_->shown()) return;
    set_stage(Stage::preparing);
    const SceneWish before = scene_->shown();
    try {
        scene_->show(current_.scene);
        milliseconds_per_pixel_ = 0;
    } catch (const InputError&) {
        scene_->show(before);
        throw;
    }
}

void FrameRenderer::draw() {
    set_stage(Stage::drawing);
    const PreparedScene& world = scene_->world();
    require_camera_outside(world.scene(), world.rays(), current_.camera);
    const float scale = draft_scale(current_.camera);
    std::optional<ViewFrame> first = draft(scale, {});
    publish(std::move(*first));
    if (scale > 1) {
        std::optional<ViewFrame> full = draft(1, stopped_);
        if (!full) return;
        publish(std::move(*full));
    }
    ProgressiveImage image(world, current_.camera, current_.samples, stopped_);
    while (!image.finished()) {
        if (!image.add_pass()) return;
        publish(image.frame());
    }
    set_stage(Stage::resting);
}

std::optional<ViewFrame> FrameRenderer::draft(float scale, std::stop_token stop) {
    std::optional<ViewFrame> frame =
        draw_draft(scene_->world(), current_.camera, scale, std::move(stop));
    if (frame)
        milliseconds_per_pixel_ =
            frame->milliseconds / (double(frame->camera.width) * double(frame->camera.height));
    return frame;
}

// The finest that the last draft says there is time for.
float FrameRenderer::draft_scale(const Camera& camera) const {
    if (milliseconds_per_pixel_ == 0) return kFirstScale;
    const double full = milliseconds_per_pixel_ * double(camera.width) * double(camera.height);
    for (const float scale : kScales)
        if (full / double(scale * scale) <= kDraftMilliseconds) return scale;
    return std::end(kScales)[-1];
}

void FrameRenderer::publish(ViewFrame frame) {
    frame.wish = current_.scene;
    {
        const std::lock_guard lock(mutex_);
        news_ = {std::make_shared<const ViewFrame>(std::move(frame)), current_time_};
    }
    on_news_();
}

void FrameRenderer::set_stage(Stage stage) {
    {
        const std::lock_guard lock(mutex_);
        status_.stage = stage;
    }
    on_news_();
}

}  // namespace tallow
