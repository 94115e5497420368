#include <cmath>
#include <span>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/weights/pickle.h>
#include <earpoint/weights_testing/checkpoint_bytes.h>

namespace earpoint {
namespace {

using namespace testing_bytes;  // NOLINT(google-build-using-namespace): the builders of this test
using Kind = PickleValue::Kind;

/// Keeps the bytes alive together with what was read from them.
struct Read {
  explicit Read(std::string source)
      : bytes(std::move(source)), pickle(parse_pickle(std::as_bytes(std::span(bytes)), "x")) {}
  std::string bytes;
  Pickle pickle;
  [[nodiscard]] const PickleValue& top() const { return *pickle.top; }
};

std::string refusal(const std::string& bytes) {
  try {
    (void)parse_pickle(std::as_bytes(std::span(bytes)), "x");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Pickle, ReadsNumbersOfEveryWidth) {
  const Read read(pickled("(K\xFFM\xFF\xFFJ\xFE\xFF\xFF\xFF" + std::string("\x8a\x00", 2) +
                          "\x8a\x01\x80" + integer(std::int64_t{1} << 40) + "\x8a\x09" +
                          std::string(9, '\x7F') + "G\xC0\x09\x21\xFB\x54\x44\x2D\x18" +
                          "N\x88\x89t"));
  const auto& items = read.top().items;
  ASSERT_EQ(items.size(), 11U);
  EXPECT_EQ(items[0]->integer, 255);
  EXPECT_EQ(items[1]->integer, 65535);
  EXPECT_EQ(items[2]->integer, -2);
  EXPECT_EQ(items[3]->integer, 0);
  EXPECT_EQ(items[4]->integer, -128);
  EXPECT_EQ(items[5]->integer, std::int64_t{1} << 40);
  EXPECT_EQ(items[6]->kind, Kind::big_integer);
  EXPECT_EQ(items[7]->real, -3.141592653589793);
  EXPECT_EQ(items[8]->kind, Kind::none);
  EXPECT_TRUE(items[9]->boolean);
  EXPECT_FALSE(items[10]->boolean);
}

TEST(Pickle, ReadsTextAndContainers) {
  const Read read(pickled("(\x8c\x02hi" + ("\x8d" + little_endian(std::uint64_t{2}) + "ho") +
                          "C\x01\xFF]q\x05(K\x01K\x02" + "eh\x05K\x03" + "a0" + "}K\x07K\x08s" +
                          "K\x01\x85" + ")" + "t"));
  const auto& items = read.top().items;
  ASSERT_EQ(items.size(), 7U);
  EXPECT_EQ(items[0]->text, "hi");
  EXPECT_EQ(items[1]->text, "ho");
  EXPECT_EQ(items[2]->kind, Kind::bytes);
  EXPECT_EQ(items[3]->items.size(), 3U) << "the memo shares the list, it does not copy it";
  EXPECT_EQ(items[4]->items.at(1)->integer, 8);
  EXPECT_EQ(items[5]->items.at(0)->integer, 1);
  EXPECT_TRUE(items[6]->items.empty());
}

TEST(Pickle, ReadsFramesAndMemoOfProtocolFour) {
  const Read read("\x80\x04\x95" + std::string(8, '\0') +
                  "\x8c\x08"
                  "argparse\x94\x8c\tNamespace\x94\x93\x94)\x81}\x8c\x01"
                  "aK\x05sbh\x02\x86.");
  const PickleValue& bag = *read.top().items.at(0);
  EXPECT_TRUE(bag.is_made_by("argparse", "Namespace"));
  EXPECT_EQ(bag.state().items.at(1)->integer, 5);
  EXPECT_TRUE(read.top().items.at(1)->is_global("argparse", "Namespace"));
}

TEST(Pickle, OnlyNotesWhatPythonWouldCall) {
  const Read read(pickled(global("os", "system") + tuple({text("echo harm")}) + "R"));
  EXPECT_TRUE(read.top().is_made_by("os", "system"));
  EXPECT_EQ(read.top().arguments().items.at(0)->text, "echo harm");
  EXPECT_EQ(read.top().state().kind, Kind::none);
}

TEST(Pickle, ValuesMayContainThemselves) {
  const Read read(
      pickled("]q\x01h\x01"
              "a"));
  EXPECT_EQ(read.top().items.at(0), &read.top());
}

TEST(Pickle, DeepNestingNeedsNoStack) {
  const Read read(pickled(std::string(300'000, ']') + std::string(299'999, 'a')));
  EXPECT_EQ(read.top().items.size(), 1U);
}

TEST(Pickle, MalformedOnesAreRefusedWithTheByte) {
  struct Case {
    std::string bytes;
    const char* message;
  };
  const std::vector<Case> cases{
      {"", "x: byte 0: the pickle is truncated"},
      {"\x80", "truncated"},
      {"\x80\x02", "byte 2: the pickle is truncated"},
      {"\x80\x07N.", "unknown pickle protocol 7"},
      {"\x80\x02\x01.", "byte 2: unknown pickle opcode 0x01"},
      {pickled("I1\n"), "unknown pickle opcode 0x49"},
      {pickled("ios\nsystem\n"), "unknown pickle opcode 0x69"},
      {pickled("\x82\x01"), "unknown pickle opcode 0x82"},
      {pickled(""), "takes a value from an empty stack"},
      {pickled("X\xFF\xFF\xFF\xFF"
               "a"),
       "truncated"},
      {pickled("\x8d" + std::string(8, '\xFF') + "a"), "truncated"},
      {pickled("\x8b\xFF\xFF\xFF\xFF"), "truncated"},
      {pickled("cos\nsystem"), "truncated"},
      {pickled("X\x01" + std::string(3, '\0') + "\xFF"), "is not UTF-8"},
      {pickled("t"), "refers to a mark that was not set"},
      {pickled("NN(0"), "empty stack"},  // a mark guards what is below it
      {pickled("h\x03"), "recalls value 3"},
      {pickled("NNs"), "empty stack"},
      {pickled("NNNs"), "not a dictionary"},
      {pickled("}(Nu"), "without a value"},
      {pickled("NNa"), "not a list"},
      {pickled("NNR"), "arguments that are not a tuple"},
      {pickled("NNb"), "state of a value that has none"},
      {pickled("NN\x93"), "names a class by something other"},
  };
  for (const Case& c : cases) {
    EXPECT_NE(refusal(c.bytes).find(c.message), std::string::npos)
        << c.message << " <-> " << refusal(c.bytes);
  }
}

TEST(Pickle, BombsOfValuesMarksAndMemosAreRefused) {
  const std::size_t many = 1'100'000;
  EXPECT_NE(refusal(pickled(std::string(many, ']'))).find("more than 1000000"), std::string::npos);
  EXPECT_NE(refusal(pickled(std::string(many, '('))).find("more than 1000000"), std::string::npos);
  EXPECT_NE(refusal(pickled("N" + std::string(many, '2'))).find("more than 1000000"),
            std::string::npos);
  EXPECT_NE(refusal(pickled("N" + std::string(many, '\x94'))).find("more than 1000000"),
            std::string::npos);
}

}  // namespace
}  // namespace earpoint
