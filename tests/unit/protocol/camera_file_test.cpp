#include "protocol/camera_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <variant>
#include <vector>

namespace culld::protocol {
namespace {

constexpr const char* kGood =
    R"({"eye":[1,2,3],"target":[4,5.5,6],"up":[0,1,0],"yfov":1.25,"aspect":2,"znear":0.5,"zfar":)";

std::string lookAt(const std::string& zfar = "null") { return kGood + zfar + "}"; }

std::string list(const std::string& items) {
  std::string text = "[";
  text += items;
  text += ']';
  return text;
}

std::string numbers(int count) {
  std::string text = "[";
  for (int i = 0; i < count; ++i) {
    if (i > 0) text += ',';
    text += std::to_string(i);
  }
  return text + "]";
}

std::string errorOf(const std::string& text) {
  const auto cameras = parseCameras(text, "c.json");
  return cameras ? "read " + std::to_string(cameras.value().size()) : cameras.error().message;
}

TEST(CameraFile, ReadsALookAtPose) {
  const auto cameras = parseCameras(list(lookAt("100")), "c.json");
  ASSERT_TRUE(cameras.ok()) << cameras.error().message;
  ASSERT_EQ(cameras.value().size(), 1U);
  Camera expected;
  LookAt pose;
  pose.eye = {1, 2, 3};
  pose.target = {4, 5.5, 6};
  pose.up = {0, 1, 0};
  pose.yfov_rad = 1.25;
  pose.aspect = 2.0;
  pose.znear_m = 0.5;
  pose.zfar_m = 100.0;
  expected.pose = pose;
  EXPECT_EQ(cameras.value()[0], expected);
}

TEST(CameraFile, TakesNullOrNoFarPlaneAsInfinite) {
  std::string without = lookAt();
  without.erase(without.find(",\"zfar\":null"), 12);
  for (const std::string& text : {lookAt(), without}) {
    const auto cameras = parseCameras(list(text), "c.json");
    ASSERT_TRUE(cameras.ok()) << cameras.error().message;
    EXPECT_FALSE(std::get<LookAt>(cameras.value()[0].pose).zfar_m.has_value());
  }
}

TEST(CameraFile, ReadsMatricesInFileOrder) {
  const auto cameras = parseCameras(
      R"([{"view":)" + numbers(16) + R"(,"projection":)" + numbers(16) + "}]", "c.json");
  ASSERT_TRUE(cameras.ok()) << cameras.error().message;
  const Matrices& pose = std::get<Matrices>(cameras.value()[0].pose);
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(pose.view[i], static_cast<double>(i));
    EXPECT_EQ(pose.projection[i], static_cast<double>(i));
  }
}

TEST(CameraFile, ReadsMotionBoundAndImageSizeAndSkipsNotes) {
  std::string text = lookAt();
  text.insert(1, R"("radius":0.5,"angle":0.25,"width":640,"height":480,"note":[{"a":[]},1,null],)");
  const auto cameras = parseCameras(list(text + "," + lookAt()), "c.json", {1920, 1080});
  ASSERT_TRUE(cameras.ok()) << cameras.error().message;
  const Camera& first = cameras.value()[0];
  EXPECT_EQ(first.radius_m, 0.5);
  EXPECT_EQ(first.angle_rad, 0.25);
  EXPECT_EQ(first.width_px, 640U);
  EXPECT_EQ(first.height_px, 480U);
  const Camera& second = cameras.value()[1];
  EXPECT_EQ(second.radius_m, 0.0);
  EXPECT_EQ(second.angle_rad, 0.0);
  EXPECT_EQ(second.width_px, 1920U);
  EXPECT_EQ(second.height_px, 1080U);
}

TEST(CameraFile, ReadsAnEmptyList) { EXPECT_EQ(errorOf("[]"), "read 0"); }

struct Wrong {
  std::string text, error;
};

std::string with(const std::string& from, const std::string& to) {
  std::string text = lookAt();
  const auto at = text.find(from);
  return list(lookAt() + "," + text.replace(at, from.size(), to));
}

TEST(CameraFile, NamesCameraAndFieldOfWhatIsWrong) {
  const std::string m = numbers(16);
  const Wrong table[] = {
      {list(lookAt() + "," + lookAt("0")), "c.json: camera 1: \"zfar\" is not > 0"},
      {with("1.25", "\"x\""), "c.json: camera 1: \"yfov\" is not a number"},
      {with("1.25", "true"), "c.json: camera 1: \"yfov\" is not a number"},
      {with("1.25", "null"), "c.json: camera 1: \"yfov\" is not a number"},
      {with("1.25", "[1]"), "c.json: camera 1: \"yfov\" is not a number"},
      {with("1.25", "{}"), "c.json: camera 1: \"yfov\" is not a number"},
      {with("1.25", "1e999"), "c.json: camera 1: \"yfov\" is not a finite number"},
      {with("5.5", "-1e400"), "c.json: camera 1: \"target\" is not a finite number"},
      {with("null", "\"far\""), "c.json: camera 1: \"zfar\" is not a number or null"},
      {with("[1,2,3]", "1"), "c.json: camera 1: \"eye\" is not a list of 3 numbers"},
      {with("[1,2,3]", "null"), "c.json: camera 1: \"eye\" is not a list of 3 numbers"},
      {with("[1,2,3]", "[1,2]"), "c.json: camera 1: \"eye\" is not a list of 3 numbers"},
      {with("[1,2,3]", "[1,2,3,4]"), "c.json: camera 1: \"eye\" is not a list of 3 numbers"},
      {with("[1,2,3]", "[1,2,\"3\"]"), "c.json: camera 1: \"eye\" is not a list of 3 numbers"},
      {with("[1,2,3]", "[1,2,null]"), "c.json: camera 1: \"eye\" is not a list of 3 numbers"},
      {with("[1,2,3]", "[[1,2,3]]"), "c.json: camera 1: \"eye\" is not a list of 3 numbers"},
      {with("[1,2,3]", "{\"x\":1}"), "c.json: camera 1: \"eye\" is not a list of 3 numbers"},
      {with("\"up\":[0,1,0],", ""), "c.json: camera 1: \"up\" is missing"},
      {with("\"up\"", "\"eye\""), "c.json: camera 1: \"eye\" is given twice"},
      {with("}", ",\"width\":0}"),
       "c.json: camera 1: \"width\" is not a whole number from 1 to 65536"},
      {with("}", ",\"height\":70000}"),
       "c.json: camera 1: \"height\" is not a whole number from 1 to 65536"},
      {with("}", ",\"width\":-5}"),
       "c.json: camera 1: \"width\" is not a whole number from 1 to 65536"},
      {with("}", ",\"width\":640.5}"),
       "c.json: camera 1: \"width\" is not a whole number from 1 to 65536"},
      {with("}", ",\"view\":" + m + "}"),
       "c.json: camera 1: \"eye\" does not go with \"view\" and \"projection\""},
      {"[{\"view\":" + m + "}]", "c.json: camera 0: \"projection\" is missing"},
      {"[{\"view\":" + m + ",\"projection\":" + numbers(15) + "}]",
       "c.json: camera 0: \"projection\" is not a list of 16 numbers"},
      {"[{\"view\":" + m + ",\"projection\":" + numbers(17) + "}]",
       "c.json: camera 0: \"projection\" is not a list of 16 numbers"},
      {"[{}]", "c.json: camera 0: \"eye\" is missing"},
      {"[7]", "c.json: camera 0: is not an object"},
      {"[null]", "c.json: camera 0: is not an object"},
      {"[[]]", "c.json: camera 0: is not an object"},
      {"{\"eye\":[]}", "c.json: is not a list of cameras"},
      {"3", "c.json: is not a list of cameras"},
      {"null", "c.json: is not a list of cameras"},
      {"\"cameras\"", "c.json: is not a list of cameras"},
  };
  for (const Wrong& wrong : table) EXPECT_EQ(errorOf(wrong.text), wrong.error) << wrong.text;
}

TEST(CameraFile, SaysWhereTextIsNotJson) {
  const Wrong table[] = {
      {"", "c.json: line 1, column 0: not valid JSON"},
      {"[", "c.json: line 1, column 1: not valid JSON"},
      {"[\n  nan]", "c.json: line 2, column 4: not valid JSON"},
      {"[{\"eye\":[NaN,0,0]}]", "c.json: line 1, column 10: not valid JSON"},
      {"[]x", "c.json: line 1, column 3: not valid JSON"},
      {"[1e999]", "c.json: line 1, column 6: not valid JSON"},
      {"[{\"note\":1e999}]", "c.json: line 1, column 14: not valid JSON"},
      {"[{\"\xff\":1}]", "c.json: line 1, column 4: not valid JSON"},
  };
  for (const Wrong& wrong : table) EXPECT_EQ(errorOf(wrong.text), wrong.error) << wrong.text;
}

TEST(CameraFile, ATextDoesNotEndAtAZeroByte) {
  const std::string zero(1, '\0');
  EXPECT_EQ(errorOf("[]" + zero), "c.json: line 1, column 3: not valid JSON");
  EXPECT_EQ(errorOf("[]\n" + zero + "[{}]"), "c.json: line 2, column 1: not valid JSON");
  EXPECT_EQ(errorOf("[" + zero + "]"), "c.json: line 1, column 2: not valid JSON");
  EXPECT_EQ(errorOf("[{\"no" + zero + "te\":1}]"), "c.json: line 1, column 6: not valid JSON");
}

TEST(CameraFile, RefusesTextMadeToExhaustMemoryOrStack) {
  const std::string open(2'000'000, '[');
  EXPECT_EQ(errorOf(open), "c.json: camera 0: is not an object");
  EXPECT_EQ(errorOf("[{\"note\":" + open), "c.json: camera 0: nested deeper than 64 levels");
  std::string objects = "[{\"note\":";
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  EXPECT_EQ(errorOf(objects), "c.json: camera 0: nested deeper than 64 levels");
  std::string many = "[";
  for (std::size_t i = 0; i <= kMaxFileCameras; ++i) {
    if (i > 0) many += ',';
    many += lookAt();
  }
  EXPECT_EQ(errorOf(many + "]"), "c.json: more than 100000 cameras");
}

TEST(CameraFile, SaysWhyAFileCannotBeRead) {
  const auto absent = readCameraFile("/nonexistent/c.json");
  ASSERT_FALSE(absent.ok());
  EXPECT_EQ(absent.error().message, "/nonexistent/c.json: cannot read: No such file or directory");
  const auto folder = readCameraFile("/");
  ASSERT_FALSE(folder.ok());
  EXPECT_EQ(folder.error().message, "/: cannot read: Is a directory");
}

TEST(CameraFile, ReadsAFile) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("culld_camera_file_test." + std::to_string(::getpid()) + ".json");
  std::ofstream(path) << "[" << lookAt() << "]\n";
  const auto cameras = readCameraFile(path.string());
  std::filesystem::remove(path);
  ASSERT_TRUE(cameras.ok()) << cameras.error().message;
  EXPECT_EQ(cameras.value().size(), 1U);
}

}  // namespace
}  // namespace culld::protocol
