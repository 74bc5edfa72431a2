// SPDX-License-Identifier: Apache-2.0
#include "viewer/text_painter.h"

#include <SDL_ttf.h>
#include <fmt/format.h>

#include <algorithm>

namespace tallow {
namespace {

constexpr int kPointSize = 13, kMargin = 6;
constexpr std::size_t kMostLines = 200;  // textures that are kept
constexpr SDL_Color kInk{235, 235, 225, 255};
constexpr Uint8 kGround = 150;  // opacity of 255

}  // namespace

TextPainter::TextPainter(SDL_Renderer* renderer) : renderer_(renderer) {
    if (TTF_Init() == 0) font_ = TTF_OpenFont(TALLOW_FONT, kPointSize);
    if (font_ == nullptr)
        problem_ =
            fmt::format("no text in the window: {}; install fonts-dejavu-core", TTF_GetError());
}

TextPainter::~TextPainter() {
    for (auto& [text, line] : lines_) SDL_DestroyTexture(line.texture);
    if (font_ != nullptr) TTF_CloseFont(font_);
    if (TTF_WasInit() != 0) TTF_Quit();
}

int TextPainter::line_height() const { return font_ == nullptr ? 0 : TTF_FontLineSkip(font_); }

const TextPainter::Line* TextPainter::line(const std::string& text) {
    const auto found = lines_.find(text);
    if (found != lines_.end()) {
        found->second.used = true;
        return &found->second;
    }
    SDL_Surface* surface = TTF_RenderUTF8_Blended(font_, text.c_str(), kInk);
    if (surface == nullptr) return nullptr;
    SDL_Texture* texture = SDL_CreateTextureFromSurface(renderer_, surface);
    const Line made{texture, surface->w, surface->h, true};
    SDL_FreeSurface(surface);
    return texture == nullptr ? nullptr : &lines_.emplace(text, made).first->second;
}

void TextPainter::forget_unused() {
    for (auto i = lines_.begin(); i != lines_.end();) {
        if (!i->second.used) SDL_DestroyTexture(i->second.texture);
        i = i->second.used ? std::next(i) : lines_.erase(i);
    }
    for (auto& [text, line] : lines_) line.used = false;
}

int TextPainter::draw(const std::vector<std::string>& lines, int x, int y) {
    if (font_ == nullptr || lines.empty()) return 0;
    if (lines_.size() > kMostLines) forget_unused();
    int width = 0;
    for (const std::string& text : lines)
        if (const Line* drawn = line(text)) width = std::max(width, drawn->width);
    const int skip = line_height();
    const SDL_Rect ground{x, y, width + 2 * kMargin, skip * int(lines.size()) + 2 * kMargin};
    SDL_SetRenderDrawBlendMode(renderer_, SDL_BLENDMODE_BLEND);
    SDL_SetRenderDrawColor(renderer_, 0, 0, 0, kGround);
    SDL_RenderFillRect(renderer_, &ground);
    int at = y + kMargin;
    for (const std::string& text : lines) {
        if (const Line* drawn = line(text)) {
            const SDL_Rect to{x + kMargin, at, drawn->width, drawn->height};
            SDL_RenderCopy(renderer_, drawn->texture, nullptr, &to);
        }
        at += skip;
    }
    return ground.h;
}

}  // namespace tallow
