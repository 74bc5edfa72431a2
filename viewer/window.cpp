// SPDX-License-Identifier: Apache-2.0
// Events -> session -> wishes of the renderer; its frames -> screen.
#include "viewer/window.h"

#include <SDL.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "common/base/errors.h"
#include "common/base/parallel.h"
#include "viewer/frame_renderer.h"
#include "viewer/overlay.h"
#include "viewer/picture.h"
#include "viewer/sdl_input.h"
#include "viewer/session.h"
#include "viewer/text_painter.h"

namespace tallow {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMovingWait = 4, kRestingWait = 100;  // ms for an event, at most
constexpr double kLongestStep = 0.1;  // s; a camera does not jump after the system was busy
constexpr int kMargin = 10;           // of text, pixels

OutputError sdl_error(const char* what) {
    return OutputError(
        fmt::format("{}: {}; --frames with --script needs no display", what, SDL_GetError()));
}

/// SDL's video, as long as it lives.
struct Video {
    Video() {
        SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");  // Ctrl-C is tool_main's
        SDL_SetHint(SDL_HINT_RENDER_SCALE_QUALITY, "linear");
        SDL_SetHint(SDL_HINT_VIDEO_X11_NET_WM_BYPASS_COMPOSITOR, "0");
        if (SDL_Init(SDL_INIT_VIDEO) != 0) throw sdl_error("cannot open a window");
    }
    ~Video() { SDL_Quit(); }
    Video(const Video&) = delete;
    Video& operator=(const Video&) = delete;
};

template <class T, void (*Destroy)(T*)>
struct Destroyer {
    void operator()(T* object) const { Destroy(object); }
};
template <class T, void (*Destroy)(T*)>
using Owned = std::unique_ptr<T, Destroyer<T, Destroy>>;

/// The largest size of the camera's shape that fits the screen.
std::pair<int, int> window_size(const Camera& camera) {
    SDL_Rect screen{};
    if (SDL_GetDisplayUsableBounds(0, &screen) != 0 || screen.w <= 0 || screen.h <= 0)
        return {camera.width, camera.height};
    const double shrink =
        std::min({1.0, double(screen.w) / camera.width, double(screen.h) / camera.height});
    return {std::max(1, int(camera.width * shrink)), std::max(1, int(camera.height * shrink))};
}

class Window {
public:
    Window(const Scene& scene, const ViewOptions& options, ToolRun& run)
        : run_(run), session_(scene, options) {
        const auto [width, height] = window_size(session_.camera());
        window_.reset(SDL_CreateWindow(
            fmt::format("tallow: {}", scene.file.stem().string()).c_str(), SDL_WINDOWPOS_UNDEFINED,
            SDL_WINDOWPOS_UNDEFINED, width, height, SDL_WINDOW_RESIZABLE));
        if (!window_) throw sdl_error("cannot open a window");
        renderer_.reset(SDL_CreateRenderer(window_.get(), -1, 0));
        if (!renderer_) throw sdl_error("cannot draw in the window");
        text_.emplace(renderer_.get());
        if (!text_->problem().empty()) run.progress.note(text_->problem());
        resize();
        news_event_ = SDL_RegisterEvents(1);

        const auto load = [&scene, wish = session_.state().wish(), file = cache_file(options),
                           &run] {
            return std::make_unique<ViewedScene>(scene, wish, file, run.progress, run.stats);
        };
        session_.take_change();
        frames_.emplace(load, wish(), run.threads, [event = news_event_] { wake(event); });
    }

    ~Window() {
        interrupt();  // whatever is under way is not wanted any more
        frames_.reset();
    }
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    void run() {
        Clock::time_point last = Clock::now();
        while (!session_.state().closed()) {
            take_events();
            if (interrupted()) throw Interrupted();
            frames_->rethrow_failure();
            const Clock::time_point now = Clock::now();
            const std::chrono::duration<double> step = now - last;
            last = now;
            session_.advance(std::min(step.count(), kLongestStep));
            if (session_.take_change()) {
                frames_->want(wish());
                message_.clear();
            }
            show();
        }
    }

private:
    static void wake(Uint32 type) {
        SDL_Event event{};
        event.type = type;
        SDL_PushEvent(&event);
    }

    FrameRenderer::Wish wish() const {
        return {session_.camera(), session_.state().wish(), session_.samples()};
    }

    void resize() {
        int width = 0, height = 0;
        SDL_GetWindowSize(window_.get(), &width, &height);
        session_.handle(ResizeEvent{width, height}, {});
    }

    void take_events() {
        SDL_Event event;
        if (SDL_WaitEventTimeout(&event, session_.is_moving() ? kMovingWait : kRestingWait) == 0)
            return;
        do {
            // News wake the window; what is new it asks for itself.
            if (event.type != news_event_) is_dirty_ = true;
            for (const InputEvent& input : translate(event))
                session_.handle(input, [this](const Camera& camera, Vec2 pixel) {
                    return frames_->point_under(camera, pixel);
                });
        } while (SDL_PollEvent(&event) != 0);
    }

    // Draws only what is not on the screen yet.
    void show() {
        const FrameRenderer::News news = frames_->latest();
        const FrameRenderer::Status status = frames_->status();
        const bool is_new = news.frame != shown_;
        const bool is_loading = status.stage == FrameRenderer::Stage::loading;
        if (!is_new && !is_dirty_ && !is_loading && status.stage == stage_) return;
        shown_ = news.frame;
        stage_ = status.stage;
        is_dirty_ = false;
        if (shown_) save();
        if (shown_) upload();
        draw(status);
        if (is_new && shown_) {
            const std::chrono::duration<double, std::milli> latency = Clock::now() - news.wished;
            session_.log(*shown_, latency.count());
        }
    }

    // A folder that cannot be written is no reason to close the window.
    void save() {
        try {
            if (const auto saved = session_.save_wished(*shown_, frames_->cache_name())) {
                message_ = fmt::format("wrote {}.png, .exr, .yaml", saved->string());
                run_.progress.note(message_);
            }
        } catch (const OutputError& problem) {
            message_ = problem.what();
            run_.progress.note(message_);
        }
    }

    void upload() {
        const Picture picture =
            make_picture(*shown_, session_.state().aov(), session_.state().exposure());
        int width = 0, height = 0;
        if (texture_) SDL_QueryTexture(texture_.get(), nullptr, nullptr, &width, &height);
        if (!texture_ || width != picture.width || height != picture.height)
            texture_.reset(SDL_CreateTexture(renderer_.get(), SDL_PIXELFORMAT_RGB24,
                                             SDL_TEXTUREACCESS_STREAMING, picture.width,
                                             picture.height));
        if (!texture_) throw sdl_error("cannot draw in the window");
        SDL_UpdateTexture(texture_.get(), nullptr, picture.rgb.data(), 3 * picture.width);
    }

    void draw(const FrameRenderer::Status& status) {
        SDL_SetRenderDrawColor(renderer_.get(), 20, 20, 20, 255);
        SDL_RenderClear(renderer_.get());
        if (shown_) SDL_RenderCopy(renderer_.get(), texture_.get(), nullptr, nullptr);
        int y = kMargin;
        if (shown_)
            y += text_->draw(overlay_lines(*shown_, session_.state()), kMargin, y) + kMargin;
        if (session_.state().help()) y += text_->draw(help_lines(), kMargin, y) + kMargin;
        draw_status(status);
        SDL_RenderPresent(renderer_.get());
    }

    // At the bottom: what is being done, what went wrong, what was saved.
    void draw_status(const FrameRenderer::Status& status) {
        std::vector<std::string> lines;
        const Progress::State progress = run_.progress.state();
        if (status.stage == FrameRenderer::Stage::loading)
            lines.push_back(progress.phase.empty()
                                ? "loading"
                                : fmt::format("making the cache: {} {:.0f} %", progress.phase,
                                              100 * progress.fraction));
        if (status.stage == FrameRenderer::Stage::preparing) lines.push_back("preparing");
        if (!status.problem.empty()) lines.push_back(status.problem);
        if (!message_.empty()) lines.push_back(message_);
        if (lines.empty()) return;
        int width = 0, height = 0;
        SDL_GetRendererOutputSize(renderer_.get(), &width, &height);
        const int text_height = text_->line_height() * int(lines.size()) + 2 * kMargin;
        text_->draw(lines, kMargin, height - text_height - 2 * kMargin);
        if (status.stage != FrameRenderer::Stage::loading || progress.phase.empty()) return;
        const SDL_Rect bar{kMargin, height - kMargin - 4,
                           int(progress.fraction * (width - 2 * kMargin)), 4};
        SDL_SetRenderDrawColor(renderer_.get(), 235, 235, 225, 255);
        SDL_RenderFillRect(renderer_.get(), &bar);
    }

    ToolRun& run_;
    Session session_;
    Owned<SDL_Window, SDL_DestroyWindow> window_;
    Owned<SDL_Renderer, SDL_DestroyRenderer> renderer_;
    std::optional<TextPainter> text_;
    Owned<SDL_Texture, SDL_DestroyTexture> texture_;
    Uint32 news_event_ = 0;
    std::optional<FrameRenderer> frames_;
    std::shared_ptr<const ViewFrame> shown_;
    FrameRenderer::Stage stage_ = FrameRenderer::Stage::loading;
    bool is_dirty_ = true;
    std::string message_;
};

}  // namespace

void show_window(const Scene& scene, const ViewOptions& options, ToolRun& run) {
    const Video video;
    Window(scene, options, run).run();
}

}  // namespace tallow
