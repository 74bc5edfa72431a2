// SPDX-License-Identifier: Apache-2.0
// Script -> frames in files.
#include "viewer/replay.h"

#include <fmt/format.h>

#include "common/base/errors.h"
#include "render/frame_range.h"
#include "viewer/progressive_image.h"
#include "viewer/screenshot.h"
#include "viewer/script.h"
#include "viewer/session.h"
#include "viewer/viewed_scene.h"

namespace tallow {
namespace {

constexpr double kSecondsPerFrame = 1.0 / 30;

class Replay {
public:
    Replay(const Scene& scene, const ViewOptions& options, ToolRun& run)
        : options_(options),
          run_(run),
          events_(options.script ? read_script(*options.script) : std::vector<ScriptedEvent>{}),
          session_(scene, options),
          viewed_(scene, session_.state().wish(), cache_file(options), run.progress, run.stats) {}

    void play() {
        for (int number = 0; number < *options_.frames; ++number) {
            take_events(number);
            if (session_.state().closed()) return;
            session_.advance(kSecondsPerFrame);
            if (session_.take_change())
                start_over(number);
            else if (image_ && !image_->finished())
                add_pass();
            show(number);
        }
    }

private:
    void take_events(int number) {
        const auto point_under = [&](const Camera& camera, Vec2 pixel) {
            const auto hit = viewed_.world().rays().intersect(camera_ray(camera, pixel.x, pixel.y));
            return hit ? std::optional(hit->position) : std::nullopt;
        };
        for (; next_ < events_.size() && events_[next_].frame <= number; ++next_)
            session_.handle(events_[next_].event, point_under);
    }

    // What cannot be shown leaves the frame that was there, as in the window.
    void start_over(int number) {
        try {
            if (!(viewed_.shown() == session_.state().wish())) change_scene();
            const PreparedScene& world = viewed_.world();
            require_camera_outside(world.scene(), world.rays(), session_.camera());
            frame_ = draw_draft(world, session_.camera(), 1, {});
            frame_->wish = viewed_.shown();
            image_.emplace(world, session_.camera(), session_.samples(), std::stop_token());
        } catch (const InputError& problem) {
            if (!frame_) throw;
            image_.reset();
            run_.progress.note(fmt::format("frame {}: {}", number, problem.what()));
        }
    }

    void change_scene() {
        image_.reset();
        const SceneWish before = viewed_.shown();
        try {
            viewed_.show(session_.state().wish());
        } catch (const InputError&) {
            viewed_.show(before);
            throw;
        }
    }

    void add_pass() {
        image_->add_pass();
        frame_ = image_->frame();
        frame_->wish = viewed_.shown();
    }

    void show(int number) {
        session_.log(*frame_, frame_->milliseconds);
        if (const auto saved = session_.save_wished(*frame_, viewed_.cache_name()))
            run_.progress.note(fmt::format("wrote {}.png, .exr, .yaml", saved->string()));
        if (!options_.output.empty())
            write_frame(frame_file(options_.output, number), *frame_, session_.state(),
                        session_.metadata(viewed_.cache_name()));
    }

    const ViewOptions& options_;
    ToolRun& run_;
    std::vector<ScriptedEvent> events_;
    std::size_t next_ = 0;  // of events_
    Session session_;
    ViewedScene viewed_;
    std::optional<ProgressiveImage> image_;
    std::optional<ViewFrame> frame_;
};

}  // namespace

void replay(const Scene& scene, const ViewOptions& options, ToolRun& run) {
    Replay(scene, options, run).play();
}

}  // namespace tallow
