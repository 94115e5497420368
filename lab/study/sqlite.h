#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace earpoint {

/// A SQLite file. What SQLite reports is thrown as InputError that names the file.
class Database {
 public:
  /// @param to_read  only; otherwise the file is made if it is not there
  Database(const std::filesystem::path& file, bool to_read);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Statements without parameters; rows are passed over.
  void run(const char* statements);
  /// Rows that the last statement changed.
  [[nodiscard]] int changes() const;
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  friend class Statement;
  [[noreturn]] void fail() const;

  std::string name_;
  sqlite3* handle_ = nullptr;
};

/// One statement with parameters, which are bound in order.
class Statement {
 public:
  Statement(Database& database, std::string_view text);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(std::string_view value);
  Statement& bind(int value);
  Statement& bind(double value);

  /// @return whether there is a (further) row
  bool step();
  /// For statements that give no rows.
  void run();

  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] double real(int column) const;

 private:
  void check(int result) const;

  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

/// Statements that are all done, or none of them. No other process writes meanwhile.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();  ///< undoes what was not committed
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit();

 private:
  Database& database_;
  bool open_ = true;
};

}  // namespace earpoint
