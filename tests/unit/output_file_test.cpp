// SPDX-License-Identifier: Apache-2.0
#include "common/base/output_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <sstream>

#include "common/base/errors.h"
#include "tests/support/error_text.h"

namespace tallow {
namespace {

namespace fs = std::filesystem;

/// An empty folder for each test.
class OutputFileTest : public testing::Test {
protected:
    OutputFileTest()
        : folder_(fs::path(TALLOW_TEST_OUT) / "output_file" /
                  testing::UnitTest::GetInstance()->current_test_info()->name()) {
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }

    static std::string read(const fs::path& file) {
        std::ostringstream text;
        text << std::ifstream(file, std::ios::binary).rdbuf();
        return text.str();
    }
    static void write(const fs::path& file, const std::string& text) {
        OutputFile output(file);
        output.write(text);
        output.commit();
    }

    fs::path folder_;
};

TEST_F(OutputFileTest, AppearsUnderItsNameOnCommitOnly) {
    const fs::path file = folder_ / "a.txt";
    OutputFile output(file);
    output.write("one ");
    output.write("two");
    EXPECT_FALSE(fs::exists(file));
    EXPECT_EQ(output.temporary(), folder_ / "a.txt.tmp");
    output.commit();
    EXPECT_EQ(read(file), "one two");
    EXPECT_FALSE(fs::exists(folder_ / "a.txt.tmp"));
}

TEST_F(OutputFileTest, LeavesTheOldFileWholeWithoutCommit) {
    const fs::path file = folder_ / "a.txt";
    write(file, "old");
    {
        OutputFile output(file);
        output.write("half of the n");
        EXPECT_EQ(read(file), "old");
    }
    EXPECT_EQ(read(file), "old");
    EXPECT_FALSE(fs::exists(folder_ / "a.txt.tmp"));
    write(file, "new");
    EXPECT_EQ(read(file), "new");
}

TEST_F(OutputFileTest, TakesOverWhatALibraryWroteByName) {
    const fs::path file = folder_ / "a.txt";
    OutputFile output(file);
    std::ofstream(output.temporary()) << "by name";
    output.commit();
    EXPECT_EQ(read(file), "by name");
}

TEST_F(OutputFileTest, IsRefusedBeforeTheWork) {
    write(folder_ / "old.txt", "old");
    fs::create_symlink("old.txt", folder_ / "link.txt");
    for (const char* name : {"new.txt", "old.txt", "link.txt"}) require_writable(folder_ / name);
    require_writable("/dev/null");
    EXPECT_EQ(read(folder_ / "old.txt"), "old");
    EXPECT_FALSE(fs::exists(folder_ / "new.txt"));

    const auto refusal = [](const fs::path& file) {
        return error_text<OutputError>([&] { require_writable(file); });
    };
    const fs::path nowhere = folder_ / "no" / "a.txt", beneath = folder_ / "old.txt" / "a.txt";
    EXPECT_EQ(refusal(nowhere),
              nowhere.string() + ": cannot be written: No such file or directory");
    EXPECT_EQ(refusal(beneath), beneath.string() + ": cannot be written: Not a directory");
    EXPECT_EQ(refusal(folder_), folder_.string() + ": cannot be written: Is a directory");
}

TEST_F(OutputFileTest, WritesThroughASymbolicLink) {
    write(folder_ / "target.txt", "old");
    fs::create_symlink("target.txt", folder_ / "link.txt");
    write(folder_ / "link.txt", "new");
    EXPECT_TRUE(fs::is_symlink(folder_ / "link.txt"));
    EXPECT_EQ(read(folder_ / "target.txt"), "new");
}

TEST_F(OutputFileTest, RefusesAMissingFolder) {
    const fs::path file = folder_ / "missing" / "a.txt";
    EXPECT_EQ(error_text<OutputError>([&] { OutputFile output(file); }),
              file.string() + ": cannot be written: No such file or directory");
}

TEST_F(OutputFileTest, RefusesAFolder) {
    EXPECT_EQ(error_text<OutputError>([&] { OutputFile output(folder_); }),
              folder_.string() + ": cannot be written: Is a directory");
    EXPECT_TRUE(fs::is_directory(folder_));
}

TEST_F(OutputFileTest, ReportsAFullDiskAndLeavesTheDeviceAlone) {
    ASSERT_TRUE(fs::exists("/dev/full"));
    OutputFile output("/dev/full");
    EXPECT_EQ(output.temporary(), "/dev/full");
    EXPECT_EQ(error_text<OutputError>([&] { output.write("x"); }),
              "/dev/full: cannot be written: No space left on device");
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(OutputFileTest, WritesToADeviceInPlace) {
    write("/dev/null", "x");
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace tallow
