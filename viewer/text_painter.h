// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SDL.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

struct _TTF_Font;

namespace tallow {

/// Draws lines of text into a window, light on a dark ground that lets the picture through. The
/// only user of SDL_ttf.
class TextPainter {
public:
    /// `renderer` must outlive it. Without the font it draws nothing; problem() says why.
    explicit TextPainter(SDL_Renderer* renderer);
    ~TextPainter();
    TextPainter(const TextPainter&) = delete;
    TextPainter& operator=(const TextPainter&) = delete;

    /// At (x, y), pixels of the window. Returns the height that the lines take.
    int draw(const std::vector<std::string>& lines, int x, int y);
    int line_height() const;
    const std::string& problem() const { return problem_; }

private:
    struct Line {
        SDL_Texture* texture;
        int width, height;
        bool used;
    };
    const Line* line(const std::string& text);
    void forget_unused();

    SDL_Renderer* renderer_;
    _TTF_Font* font_ = nullptr;
    std::map<std::string, Line> lines_;  // of this frame and the last
    std::string problem_;
};

}  // namespace tallow
