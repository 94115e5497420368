#include <array>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/weights/checkpoint.h>
#include <earpoint/weights_testing/checkpoint_bytes.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using namespace testing_bytes;  // NOLINT(google-build-using-namespace): the builders of this test

std::string floats(const std::vector<float>& values) {
  std::string bytes;
  for (const float value : values) bytes += little_endian(value);
  return bytes;
}

/// A checkpoint whose pickle is `body`, with the storages "0", "1", ... in the folder "top/".
std::vector<std::byte> checkpoint_of(const std::string& body,
                                     const std::vector<std::string>& storages) {
  std::vector<Member> members{{"top/data.pkl", pickled(body)}};
  for (std::size_t i = 0; i < storages.size(); ++i) {
    members.push_back({"top/data/" + std::to_string(i), storages[i]});
  }
  return zipped(members);
}

/// A checkpoint with one tensor "t", over the storage 1, 2, 3, 4, 5, 6.
std::vector<std::byte> with_tensor(const TensorBytes& tensor) {
  return checkpoint_of(dictionary({{"state_dict", dictionary({{"t", tensor.bytes()}})}}),
                       {floats({1, 2, 3, 4, 5, 6})});
}

std::string refusal(std::span<const std::byte> bytes) {
  try {
    (void)parse_checkpoint(bytes, "x.ckpt");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::vector<float> values_of(const Checkpoint& checkpoint, const std::string& name) {
  const auto values = checkpoint.state_dict.at(name).as<float>();
  return {values.begin(), values.end()};
}

using Floats = std::vector<float>;

TEST(Checkpoint, HonoursOffsetsAndStrides) {
  TensorBytes tensor;
  tensor.stored = 6;
  tensor.shape = {3};
  tensor.offset = 2;
  EXPECT_EQ(values_of(parse_checkpoint(with_tensor(tensor), "x"), "t"), (Floats{3, 4, 5}));

  tensor.shape = {3, 2};  // the transpose of the storage seen as 2 x 3
  tensor.strides = {1, 3};
  tensor.offset = 0;
  EXPECT_EQ(values_of(parse_checkpoint(with_tensor(tensor), "x"), "t"), (Floats{1, 4, 2, 5, 3, 6}));

  tensor.shape = {2, 2};  // one row, repeated
  tensor.strides = {0, 1};
  tensor.offset = 4;
  EXPECT_EQ(values_of(parse_checkpoint(with_tensor(tensor), "x"), "t"), (Floats{5, 6, 5, 6}));

  tensor.shape = {};  // a scalar
  tensor.strides = {};
  tensor.offset = 5;
  EXPECT_EQ(values_of(parse_checkpoint(with_tensor(tensor), "x"), "t"), (Floats{6}));

  tensor.shape = {0, 3};
  tensor.strides = {3, 1};
  tensor.offset = 6;
  EXPECT_EQ(parse_checkpoint(with_tensor(tensor), "x").state_dict.at("t").elements(), 0);
}

TEST(Checkpoint, TensorsShareStorages) {
  TensorBytes first;
  TensorBytes second;
  second.offset = 1;
  second.shape = {1};
  const auto bytes = checkpoint_of(
      dictionary({{"state_dict", dictionary({{"a", first.bytes()}, {"b", second.bytes()}})}}),
      {floats({7, 8})});
  const Checkpoint checkpoint = parse_checkpoint(bytes, "x");
  EXPECT_EQ(values_of(checkpoint, "a"), (Floats{7, 8}));
  EXPECT_EQ(values_of(checkpoint, "b"), (Floats{8}));
}

TEST(Checkpoint, EveryStorageTypeIsKnown) {
  const std::vector<std::pair<const char*, DType>> types{
      {"FloatStorage", DType::f32},     {"DoubleStorage", DType::f64}, {"HalfStorage", DType::f16},
      {"BFloat16Storage", DType::bf16}, {"LongStorage", DType::i64},   {"IntStorage", DType::i32},
      {"ShortStorage", DType::i16},     {"CharStorage", DType::i8},    {"ByteStorage", DType::u8},
      {"BoolStorage", DType::boolean}};
  for (const auto& [name, dtype] : types) {
    TensorBytes tensor;
    tensor.storage_type = global("torch", name);
    std::string storage(2 * size_of(dtype), '\1');
    const auto bytes =
        checkpoint_of(dictionary({{"predictor", dictionary({{"t", tensor.bytes()}})}}), {storage});
    const Checkpoint checkpoint = parse_checkpoint(bytes, "x");
    EXPECT_EQ(checkpoint.state_dict.at("t").dtype, dtype) << name;
    EXPECT_EQ(checkpoint.state_dict.at("t").data.size(), storage.size()) << name;
  }
}

TEST(Checkpoint, OptionsComeFromDictionariesAndAttributeBags) {
  const std::string options = dictionary({{"flag", "\x88"},
                                          {"count", integer(3)},
                                          {"rate", "G\x3F\xE0" + std::string(6, '\0')},
                                          {"name", text("vigas")},
                                          {"nothing", "N"},
                                          {"opaque", global("os", "system") + ")R"}});
  const std::string weights = dictionary({{"t", TensorBytes().bytes()}});
  const std::string bag = global("argparse", "Namespace") + ")\x81" + options + "b";
  const std::string lightning = global("pytorch_lightning.utilities.parsing", "AttributeDict") +
                                ")\x81" + options.substr(1);  // items are set on the object itself
  for (const auto& [key, value] : std::vector<std::pair<std::string, std::string>>{
           {"hparams", options}, {"hparams", bag}, {"hyper_parameters", lightning}}) {
    const auto bytes =
        checkpoint_of(dictionary({{"state_dict", weights}, {key, value}}), {floats({1, 2})});
    const auto hparams = parse_checkpoint(bytes, "x").hparams;
    EXPECT_EQ(hparams.size(), 4U);
    EXPECT_EQ(hparams.at("flag"), HyperParameter(true));
    EXPECT_EQ(hparams.at("count"), HyperParameter(std::int64_t{3}));
    EXPECT_EQ(hparams.at("rate"), HyperParameter(0.5));
    EXPECT_EQ(hparams.at("name"), HyperParameter(std::string("vigas")));
  }
}

TEST(Checkpoint, ForeignClassesAreSkippedWhereNothingIsNeededOfThem) {
  const std::string weights = global("collections", "OrderedDict") + ")R(" + text("t") +
                              TensorBytes().bytes() + "u}" + text("_metadata") + "Nsb";
  const std::string evil = global("os", "system") + tuple({text("echo harm")}) + "R";
  const auto bytes = checkpoint_of(
      dictionary({{"epoch", integer(3)}, {"optimizer_states", evil}, {"state_dict", weights}}),
      {floats({1, 2})});
  EXPECT_EQ(values_of(parse_checkpoint(bytes, "x"), "t"), (Floats{1, 2}));
}

TEST(Checkpoint, TheBareStateDictIsRead) {
  const auto bytes = checkpoint_of(dictionary({{"t", TensorBytes().bytes()}}), {floats({1, 2})});
  EXPECT_EQ(values_of(parse_checkpoint(bytes, "x"), "t"), (Floats{1, 2}));
}

TEST(Checkpoint, WrongTensorsAreNamed) {
  const auto with = [](const std::function<void(TensorBytes&)>& change) {
    TensorBytes tensor;
    tensor.stored = 6;
    change(tensor);
    return refusal(with_tensor(tensor));
  };
  const auto expect = [](const std::string& message, const std::string& part) {
    EXPECT_EQ(message.rfind("x.ckpt: tensor 't': ", 0), 0U) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  constexpr std::int64_t kHuge = std::int64_t{1} << 62;
  EXPECT_EQ(with([](auto&) {}), "accepted");
  expect(with([](auto& t) { t.offset = 5; }), "offset 5, size [2] and stride [1] leave");
  expect(with([](auto& t) { t.offset = -1; }), "offset is negative: -1");
  expect(with([](auto& t) { t.shape = {-2}; }), "size is negative");
  expect(with([](auto& t) { t.strides = {-1}; }), "stride is negative");
  expect(with([](auto& t) { t.strides = {6}; }), "leave the storage");
  expect(with([](auto& t) { t.strides = {1, 1}; }), "different lengths");
  expect(with([](auto& t) { t.shape = {kHuge}; }), "is too large");
  expect(with([](auto& t) { t.shape = {3}, t.strides = {kHuge}; }), "leave the storage");
  expect(with([](auto& t) { t.shape = {2, 2}, t.strides = {kHuge, kHuge}; }), "leave the storage");
  expect(with([](auto& t) { t.shape.assign(65, 1), t.strides.assign(65, 1); }), "at most 64");
  expect(with([](auto& t) { t.stored = 7; }), "storage of 7 elements of 4 bytes, found 24");
  expect(with([](auto& t) { t.stored = -7; }), "stored elements is negative");
  expect(with([](auto& t) { t.key = "9"; }), "'top/data/9' is not in the archive");
  expect(with([](auto& t) { t.key = "../data.pkl"; }), "'top/data/../data.pkl' is not in");
  expect(with([](auto& t) { t.storage_type = global("os", "system"); }), "'os.system'");
  expect(with([](auto& t) { t.shape = {1 << 20}, t.strides = {0}; }), "4 times as large");
}

TEST(Checkpoint, WhatIsNeededMustBeWhatItShould) {
  const auto message = [](const std::string& body) { return refusal(checkpoint_of(body, {})); };
  const auto state = [&](const std::string& value) {
    return message(dictionary({{"state_dict", value}}));
  };
  const std::string tensor = TensorBytes().bytes();
  EXPECT_NE(message("]").find("not a dictionary"), std::string::npos);
  EXPECT_NE(message("}").find("neither 'state_dict' nor 'predictor'"), std::string::npos);
  EXPECT_NE(state("]").find("'state_dict' is not a dictionary"), std::string::npos);
  EXPECT_EQ(state(dictionary({{"t", "N"}})),
            "x.ckpt: tensor 't': expected a tensor, found nothing");
  EXPECT_EQ(state(dictionary({{"t", global("os", "system") + ")R"}})),
            "x.ckpt: tensor 't': expected a tensor, found an object of the class 'os.system'");
  EXPECT_NE(state("}" + integer(1) + tensor + "s").find("name is not a string"), std::string::npos);
  EXPECT_NE(state(dictionary({{"t", tensor}, {"t", tensor}})).find("'t': occurs twice"),
            std::string::npos);
  EXPECT_NE(state(dictionary({{"t", global("torch._utils", "_rebuild_tensor_v2") + ")R"}}))
                .find("at least 4 properties, found 0"),
            std::string::npos);
  EXPECT_NE(message(dictionary({{"state_dict", "}"}, {"hparams", global("a", "B") + ")R"}}))
                .find("hparams are neither"),
            std::string::npos);
  // A value that contains itself is refused, without endless recursion.
  EXPECT_NE(state("}q\x01" + text("t") + "h\x01s").find("expected a tensor, found a dictionary"),
            std::string::npos);
}

TEST(Checkpoint, DamagedArchivesAreRefused) {
  const auto good = with_tensor({.stored = 6});
  EXPECT_EQ(refusal(good), "accepted");
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_NE(refusal(std::span(good).first(size)), "accepted") << size;
  }

  const std::string body = dictionary({{"state_dict", dictionary({{"t", TensorBytes().bytes()}})}});
  const Member pickle{"a/data.pkl", pickled(body)};
  const Member storage{"a/data/0", floats({1, 2})};
  const auto expect = [](const std::vector<Member>& members, const std::string& part) {
    const std::string message = refusal(zipped(members));
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect({pickle, storage}, "accepted");
  expect({{"data.pkl", pickle.data}, {"data/0", storage.data}}, "accepted");
  expect({}, "without a data.pkl");
  expect({{"a/b/data.pkl", pickle.data}}, "without a data.pkl");
  expect({pickle, {"b/data.pkl", pickle.data}}, "more than one data.pkl");
  expect({pickle, storage, storage}, "occurs twice");
  expect({pickle, {"a/data/0", storage.data, 8}}, "is compressed or encrypted");
  expect({pickle, {"a/data/0", storage.data, 0, 1234}}, "'a/data/0'");
  expect({pickle, {"a/data/0", storage.data, 0, std::nullopt, 0x7FFFFFFF}}, "x.ckpt: ");
  expect({pickle, storage, {"a/byteorder", "big"}}, "big-endian");
  expect({pickle, storage, {"a/byteorder", "little"}}, "accepted");
  expect({pickle, {"a/data/0", std::string(8, '\2')}, {"\xFF", ""}}, "not UTF-8");
}

TEST(Checkpoint, BooleansAreZeroOrOne) {
  TensorBytes tensor;
  tensor.storage_type = global("torch", "BoolStorage");
  const std::string body = dictionary({{"state_dict", dictionary({{"t", tensor.bytes()}})}});
  EXPECT_EQ(refusal(checkpoint_of(body, {std::string("\0\1", 2)})), "accepted");
  EXPECT_NE(refusal(checkpoint_of(body, {std::string("\0\2", 2)})).find("other than 0 and 1"),
            std::string::npos);
}

TEST(Checkpoint, FilesOfOtherKindsAreRefused) {
  EXPECT_NE(refusal({}).find("x.ckpt: is empty"), std::string::npos);
  EXPECT_NE(refusal(std::vector<std::byte>(1000)).find("is not a complete zip archive"),
            std::string::npos);
  EXPECT_THROW((void)import_checkpoint("/missing.ckpt"), InputError);
  EXPECT_THROW((void)import_checkpoint("/"), InputError);
}

TEST(Checkpoint, FileAndBytesGiveTheSame) {
  const fs::path path =
      EARPOINT_SOURCE_DIR "/src/networks/vigas/testdata/C_mini_noresnet/best_val.ckpt";
  const Checkpoint from_file = import_checkpoint(path);
  EXPECT_EQ(from_file.state_dict, parse_checkpoint(read_file(path), "x").state_dict);
  EXPECT_EQ(from_file.state_dict.size(), 4U + 2 + 4 * 12 + 4 * 4);
  EXPECT_EQ(from_file.hparams.at("dataset"), HyperParameter(std::string("soundspaces_nvas")));
  EXPECT_EQ(from_file.hparams.at("lr"), HyperParameter(0.001));
}

}  // namespace
}  // namespace earpoint
