// SPDX-License-Identifier: Apache-2.0
#include "render/frame_range.h"

#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "tests/support/error_text.h"

namespace tallow {
namespace {

TEST(FrameRange, ReadsOneFrameOrSeveral) {
    EXPECT_EQ(parse_frames("7").first, 7);
    EXPECT_EQ(parse_frames("7").last, 7);
    EXPECT_FALSE(parse_frames("7-7").has_many());
    EXPECT_EQ(parse_frames("0-35").first, 0);
    EXPECT_EQ(parse_frames("0-35").last, 35);
    EXPECT_TRUE(parse_frames("0-35").has_many());
}

TEST(FrameRange, RefusesTheRest) {
    for (const char* text : {"-3", "3-", "5-4", "a", "1-2-3", "1.5", "1 - 2", "", "1--2", "+1",
                             "99999999999", "0-99999999999"})
        EXPECT_EQ(error_text<UsageError>([&] { parse_frames(text); }),
                  std::string("--frames: expected a frame A or frames A-B, 0 <= A <= B, got '") +
                      text + "'");
}

TEST(FrameRange, IsThatOfTheCamera) {
    Camera camera{"turn", {0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 0.6f, 8, 8};
    EXPECT_EQ(error_text<UsageError>([&] {
                  require_frames(camera, {0, 0});
              }),
              "--frames: expected a camera with a turntable or keyframes, got 'turn', which does "
              "not move");
    camera.motion = Turntable{36, {0, 1, 0}, kTwoPi};
    require_frames(camera, {0, 35});
    EXPECT_EQ(error_text<UsageError>([&] {
                  require_frames(camera, {30, 36});
              }),
              "--frames: expected frames 0 to 35 of camera 'turn', got 36");
}

TEST(FrameFile, PutsTheNumberInPlaceOfTheField) {
    EXPECT_EQ(frame_file("out/turn_####.exr", 7), "out/turn_0007.exr");
    EXPECT_EQ(frame_file("turn_####.exr", 12345), "turn_12345.exr");
    EXPECT_EQ(frame_file("#.png", 0), "0.png");
    EXPECT_EQ(frame_file("##_of_###.png", 3), "03_of_003.png");
    EXPECT_EQ(frame_file("shot#2/turn.exr", 3), "shot#2/turn.exr");
    EXPECT_TRUE(has_frame_field("a/b_##.exr"));
    EXPECT_FALSE(has_frame_field("a#/b.exr"));
}

}  // namespace
}  // namespace tallow
