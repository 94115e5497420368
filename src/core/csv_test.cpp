#include <array>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/csv.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::array<std::string_view, 2> kColumns = {"time_s", "x"};

std::string message(std::string_view text) {
  try {
    (void)parse_number_csv(text, "walk.csv", kColumns);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(NumberCsv, ReadsRowsAndSkipsCommentsAndBlankLines) {
  const auto rows =
      parse_number_csv("# a walk\r\ntime_s, x\r\n\r\n0, 1.5\r\n2,-3e-1", "w", kColumns);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].line, 4);
  EXPECT_EQ(rows[0].values, (std::vector<double>{0, 1.5}));
  EXPECT_EQ(rows[1].values, (std::vector<double>{2, -0.3}));
}

TEST(NumberCsv, NamesTheLineAndTheColumn) {
  EXPECT_EQ(message("time_s,x\n0,\n"), "walk.csv: line 2, x: the cell is empty; give a number");
  EXPECT_EQ(message("time_s,x\n0,1\n1,nan\n"),
            "walk.csv: line 3, x: expected a finite number, found 'nan'");
  EXPECT_EQ(message("time_s,x\n0,1x\n"),
            "walk.csv: line 2, x: expected a finite number, found '1x'");
  EXPECT_EQ(message("time_s,x\n0\n"), "walk.csv: line 2: expected 2 cells, found 1");
  EXPECT_EQ(message("t,x\n0,1\n"), "walk.csv: line 1: expected the header time_s,x, found 't,x'");
  EXPECT_EQ(message("time_s,x\n"), "walk.csv: has no rows after its header");
  EXPECT_EQ(message(""), "walk.csv: is empty; its first line must be time_s,x");
}

TEST(NumberCsv, ReadsWhatSpreadsheetsWrite) {
  const std::vector<double> expected = {0.5, -1.25};
  for (const char* text : {"\xEF\xBB\xBFtime_s,x\r\n0.5,-1.25\r\n", "time_s;x\n0.5;-1.25\n",
                           "time_s\tx\n0.5\t-1.25\n", "\xEF\xBB\xBFtime_s;x\r\n0,5;-1,25\r\n"}) {
    const auto rows = parse_number_csv(text, "w", kColumns);
    ASSERT_EQ(rows.size(), 1U) << text;
    EXPECT_EQ(rows[0].values, expected) << text;
  }
  EXPECT_EQ(message("\xFF\xFEt"), "walk.csv: is UTF-16 text; save it as CSV in UTF-8");
}

}  // namespace
}  // namespace earpoint
