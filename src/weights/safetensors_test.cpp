#include <array>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// A file made by hand: length, header, `data_size` bytes of data (all 1).
std::vector<std::byte> file_of(const std::string& header, std::size_t data_size = 0) {
  std::vector<std::byte> bytes(8);
  for (std::size_t i = 0; i < 8; ++i) {
    bytes[i] = static_cast<std::byte>((header.size() >> (8 * i)) & 0xFFU);
  }
  for (const char c : header) bytes.push_back(static_cast<std::byte>(c));
  bytes.resize(bytes.size() + data_size, std::byte{1});
  return bytes;
}

/// The message with which a file is refused.
std::string refusal(std::span<const std::byte> bytes) {
  try {
    (void)parse_safetensors(bytes, "x.safetensors");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string refusal(const std::string& header, std::size_t data_size = 0) {
  return refusal(file_of(header, data_size));
}

SafetensorsFile sample() {
  const std::array<float, 3> floats{1.5F, -2, 0};
  const std::array<std::int64_t, 1> whole{-7};
  const std::array<std::uint8_t, 3> bytes{1, 2, 3};
  SafetensorsFile file;
  file.tensors["b"] = make_tensor<float>(floats, {3, 1});
  file.tensors["a\"\n\xC3\xA9"] = make_tensor<std::uint8_t>(bytes, {3});
  file.tensors["scalar"] = make_tensor<std::int64_t>(whole, {});
  file.tensors["empty"] = make_tensor<float>({}, {0, 4});
  file.metadata["format"] = "pt";
  file.metadata["json"] = R"({"a": 1})";
  return file;
}

TEST(Safetensors, WhatIsWrittenIsRead) {
  const fs::path path = fs::path(testing::TempDir()) / "safetensors_round_trip.safetensors";
  const SafetensorsFile file = sample();
  write_safetensors(path, file);
  const SafetensorsFile read = read_safetensors(path);
  EXPECT_EQ(read.tensors, file.tensors);
  EXPECT_EQ(read.metadata, file.metadata);
  fs::remove(path);
}

TEST(Safetensors, BytesAreDeterministicAndAligned) {
  const auto bytes = serialize_safetensors(sample(), "x");
  EXPECT_EQ(bytes, serialize_safetensors(parse_safetensors(bytes, "x"), "x"));
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data(), 8);
  EXPECT_EQ(length % 8, 0U);
  const std::string header(reinterpret_cast<const char*>(bytes.data()) + 8, length);
  EXPECT_NE(header.find(R"("scalar":{"data_offsets":[0,8])"), std::string::npos) << header;
  EXPECT_NE(header.find(R"("b":{"data_offsets":[8,20])"), std::string::npos) << header;
}

TEST(Safetensors, ReadsWhatTheReferenceImplementationWrote) {
  const fs::path path = fs::path(EARPOINT_SOURCE_DIR) /
                        "src/networks/vigas/testdata/C_mini_noresnet/inputs.safetensors";
  const SafetensorsFile file = read_safetensors(path);
  EXPECT_EQ(expect_tensor(file, "inputs", "src_wav", DType::f32, {2, 2, kAnySize}).shape.back(),
            1600);
  EXPECT_EQ(parse_safetensors(read_file(path), "x").tensors, file.tensors);
}

TEST(Safetensors, LengthsAreBelievedOnlyIfTheFileHasThem) {
  EXPECT_NE(refusal(std::vector<std::byte>(7)).find("too short"), std::string::npos);
  std::vector<std::byte> bytes = file_of("{}");
  bytes[0] = std::byte{3};
  EXPECT_NE(refusal(bytes).find("only 2 follow"), std::string::npos);
  bytes[7] = std::byte{0x7F};
  EXPECT_NE(refusal(bytes).find("more than 100000000"), std::string::npos);
}

TEST(Safetensors, HeadersThatAreNotTheFormatAreRefused) {
  const std::string good = R"("dtype":"U8","shape":[2],"data_offsets":[0,2])";
  EXPECT_EQ(refusal("{\"a\":{" + good + "}}  ", 2), "accepted");
  EXPECT_EQ(refusal("{}"), "accepted");
  struct Case {
    std::string header;
    const char* message;
  };
  const std::vector<Case> cases{
      {"", "not a JSON object"},
      {" {}", "not a JSON object"},
      {"[]", "not a JSON object"},
      {std::string("{}\0", 3), "not a JSON object"},
      {"{", "not valid JSON at byte"},
      {"{}{}", "not valid JSON at byte"},
      {"{\"\xFF\":1}", "not valid JSON at byte"},
      {R"({"a":1})", "tensor 'a': header: expected an object per tensor, found the number 1"},
      {R"({"a":[[]]})", "found a list"},
      {R"({"a":{}})", "has no \"dtype\""},
      {R"({"a":{"dtype":"U8","data_offsets":[0,2]}})", "has no \"shape\""},
      {R"({"a":{"dtype":"U8","shape":[2]}})", "has no \"data_offsets\""},
      {R"({"a":{"dtype":"X","shape":[2],"data_offsets":[0,2]}})", "unknown dtype 'X'"},
      {R"({"a":{"dtype":"U8","shape":[-2],"data_offsets":[0,2]}})", "negative number -2"},
      {R"({"a":{"dtype":"U8","shape":[2.0],"data_offsets":[0,2]}})", "the number 2.0"},
      {R"({"a":{"dtype":"U8","shape":[[2]],"data_offsets":[0,2]}})", "found a list"},
      {R"({"a":{"dtype":"U8","shape":2,"data_offsets":[0,2]}})", "found the number 2"},
      {R"({"a":{"dtype":"U8","shape":[18446744073709551615],"data_offsets":[0,2]}})",
       "the number 18446744073709551615"},
      {R"({"a":{"dtype":"U8","shape":[2],"data_offsets":[0,1,2]}})", "expected 2 numbers, found 3"},
      {"{\"a\":{" + good + R"(,"x":1}})", "unknown key 'x'"},
      {"{\"a\":{" + good + R"(,"shape":[2]}})", "key 'shape' occurs twice"},
      {"{\"a\":{" + good + "},\"a\":{" + good + "}}", "tensor 'a': occurs twice"},
      {R"({"__metadata__":{"k":1}})", "expected a string, found the number 1"},
      {R"({"__metadata__":{"k":"1","k":"2"}})", "key 'k' occurs twice"},
      {R"({"__metadata__":{},"__metadata__":{}})", "occurs twice"},
  };
  for (const Case& c : cases) {
    const std::string message = refusal(c.header, 2);
    EXPECT_NE(message.find(c.message), std::string::npos) << c.header << " -> " << message;
    EXPECT_EQ(message.rfind("x.safetensors: ", 0), 0U) << message;
  }
}

TEST(Safetensors, TensorsMustFillTheDataExactly) {
  const auto entry = [](const std::string& shape, const std::string& offsets) {
    return R"({"dtype":"U8","shape":)" + shape + R"(,"data_offsets":)" + offsets + "}";
  };
  const auto two = [&](const std::string& first, const std::string& second) {
    return "{\"a\":" + entry("[2]", first) + ",\"b\":" + entry("[2]", second) + "}";
  };
  EXPECT_EQ(refusal(two("[2,4]", "[0,2]"), 4), "accepted");
  EXPECT_NE(refusal(two("[0,2]", "[1,3]"), 4).find("inside another tensor"), std::string::npos);
  EXPECT_NE(refusal(two("[0,2]", "[3,5]"), 5).find("after a gap"), std::string::npos);
  EXPECT_NE(refusal(two("[0,2]", "[2,4]"), 5).find("end at byte 4 of 5"), std::string::npos);
  EXPECT_NE(refusal(two("[0,2]", "[2,4]"), 3).find("'b': data_offsets [2, 4] leave the 3"),
            std::string::npos);
  EXPECT_NE(refusal(two("[0,2]", "[4,2]"), 4).find("leave"), std::string::npos);
  EXPECT_NE(refusal("{\"a\":" + entry("[3]", "[0,2]") + "}", 2).find("needs 3 bytes"),
            std::string::npos);
  EXPECT_NE(refusal("{\"a\":" + entry("[4294967296,4294967296]", "[0,0]") + "}").find("too large"),
            std::string::npos);
}

TEST(Safetensors, BooleansAreZeroOrOne) {
  const std::string header = R"({"a":{"dtype":"BOOL","shape":[1],"data_offsets":[0,1]}})";
  std::vector<std::byte> bytes = file_of(header, 1);
  EXPECT_EQ(refusal(bytes), "accepted");
  bytes.back() = std::byte{2};
  EXPECT_NE(refusal(bytes).find("tensor 'a': is of type BOOL"), std::string::npos);
}

TEST(Safetensors, EveryTruncationIsRefused) {
  const auto bytes = serialize_safetensors(sample(), "x");
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_NE(refusal(std::span(bytes).first(size)), "accepted") << size;
  }
}

TEST(Safetensors, ExpectTensorNamesWhatIsWrong) {
  const SafetensorsFile file = sample();
  EXPECT_EQ(expect_tensor(file, "x", "b", DType::f32, {kAnySize, 1}).elements(), 3);
  const auto message = [&](const char* name, DType dtype, std::initializer_list<std::int64_t> s) {
    try {
      (void)expect_tensor(file, "x", name, dtype, s);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message("c", DType::f32, {3}), "x: has no tensor 'c'");
  EXPECT_EQ(message("b", DType::f32, {3, kAnySize, 2}),
            "x: tensor 'b': expected F32 [3, any, 2], found F32 [3, 1]");
  EXPECT_EQ(message("b", DType::i64, {3, 1}),
            "x: tensor 'b': expected I64 [3, 1], found F32 [3, 1]");
}

TEST(Safetensors, NamesThatTheFormatCannotHoldAreRefused) {
  SafetensorsFile file;
  file.tensors["__metadata__"] = make_tensor<float>({}, {0});
  EXPECT_THROW((void)serialize_safetensors(file, "x"), InputError);
  file.tensors.clear();
  file.tensors["\xFF"] = make_tensor<float>({}, {0});
  EXPECT_THROW((void)serialize_safetensors(file, "x"), InputError);
  EXPECT_THROW((void)read_safetensors("/missing.safetensors"), InputError);
}

}  // namespace
}  // namespace earpoint
