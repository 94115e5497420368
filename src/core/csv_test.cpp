#include <array>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/csv.h>
#include <earpoint/core/error.h>

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
  EXPECT_EQ(message("t,x\n0,1\n"), "walk.csv: line 1: expected the header time_s,x");
  EXPECT_EQ(message("time_s,x\n"), "walk.csv: has no rows after its header");
  EXPECT_EQ(message(""), "walk.csv: is empty; its first line must be time_s,x");
}

}  // namespace
}  // namespace earpoint
