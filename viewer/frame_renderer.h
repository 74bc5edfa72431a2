// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "viewer/progressive_image.h"
#include "viewer/viewed_scene.h"

namespace tallow {

/// Renders on a thread of its own what is wished for, so that nobody waits for it: first a draft,
/// at a lower resolution if need be, then one at the full, then passes until the picture has all
/// its samples. A new wish stops what is under way, save for the first draft: else a camera that
/// never rests would show nothing.
class FrameRenderer {
public:
    struct Wish {
        Camera camera;
        SceneWish scene;
        int samples;  // camera rays a pixel of the resting picture
    };
    enum class Stage { loading, preparing, drawing, resting };
    struct Status {
        Stage stage = Stage::loading;
        std::string problem;  // why the wish cannot be fulfilled; empty if it can
    };
    /// A frame and the time when what it shows was wished for.
    struct News {
        std::shared_ptr<const ViewFrame> frame;
        std::chrono::steady_clock::time_point wished;
    };

    /// `load` makes the scene, on the thread; `on_news` is called there whenever there is something
    /// new to show. Loops run on `threads` threads.
    FrameRenderer(std::function<std::unique_ptr<ViewedScene>()> load, Wish wish, int threads,
                  std::function<void()> on_news);
    /// Stops what is under way. Pass one and preparations stop only if interrupt() was called.
    ~FrameRenderer();

    void want(Wish wish);
    News latest() const;
    Status status() const;
    std::string cache_name() const;  ///< as of ViewedScene; empty while it is loading
    /// Throws what ended the thread, if something did.
    void rethrow_failure() const;
    /// Where the scene is met under a pixel; nothing while it is loading.
    std::optional<Vec3> point_under(const Camera& camera, Vec2 pixel) const;

private:
    void run();
    void work();
    bool take_wish();
    void prepare();
    void draw();
    void publish(ViewFrame frame);
    void set_stage(Stage stage);
    float draft_scale(const Camera& camera) const;
    std::optional<ViewFrame> draft(float scale, std::stop_token stop);

    std::function<std::unique_ptr<ViewedScene>()> load_;
    int threads_;
    std::function<void()> on_news_;

    mutable std::mutex mutex_;  // of what follows
    std::condition_variable wished_;
    Wish wish_;
    bool is_new_ = true, ends_ = false;
    std::chrono::steady_clock::time_point wish_time_;
    std::stop_source stop_;
    Status status_;
    News news_;
    std::exception_ptr failure_;
    const RayScene* rays_ = nullptr;  // of the scene, once it is there
    std::string cache_name_;

    // Of the thread only.
    std::unique_ptr<ViewedScene> scene_;
    Wish current_;
    std::chrono::steady_clock::time_point current_time_;
    std::stop_token stopped_;
    double milliseconds_per_pixel_ = 0;  // of drafts; 0 before the first

    std::thread thread_;  // last: it uses all of them
};

}  // namespace tallow
