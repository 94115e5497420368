#include "sqlite.h"

#include <sqlite3.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kWaitMs = 5000;  // for another process that writes

}  // namespace

Database::Database(const std::filesystem::path& file, bool to_read) : name_(file.string()) {
  const int flags = to_read ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  const int result = sqlite3_open_v2(name_.c_str(), &handle_, flags, nullptr);
  if (result != SQLITE_OK) {
    const std::string why = sqlite3_errstr(result);
    sqlite3_close(handle_);
    throw InputError(name_, "cannot be opened: " + why);
  }
  sqlite3_busy_timeout(handle_, kWaitMs);
}

Database::~Database() { sqlite3_close(handle_); }

void Database::run(const char* statements) {
  if (sqlite3_exec(handle_, statements, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

int Database::changes() const { return sqlite3_changes(handle_); }

void Database::fail() const { throw InputError(name_, sqlite3_errmsg(handle_)); }

Statement::Statement(Database& database, std::string_view text) : database_(database) {
  check(sqlite3_prepare_v2(database.handle_, text.data(), static_cast<int>(text.size()),
                           &statement_, nullptr));
}

Statement::~Statement() { sqlite3_finalize(statement_); }

void Statement::check(int result) const {
  if (result != SQLITE_OK) database_.fail();
}

Statement& Statement::bind(std::string_view value) {
  check(sqlite3_bind_text(statement_, ++bound_, value.data(), static_cast<int>(value.size()),
                          SQLITE_TRANSIENT));
  return *this;
}

Statement& Statement::bind(int value) {
  check(sqlite3_bind_int(statement_, ++bound_, value));
  return *this;
}

Statement& Statement::bind(double value) {
  check(sqlite3_bind_double(statement_, ++bound_, value));
  return *this;
}

bool Statement::step() {
  const int result = sqlite3_step(statement_);
  if (result != SQLITE_ROW && result != SQLITE_DONE) database_.fail();
  return result == SQLITE_ROW;
}

void Statement::run() { EARPOINT_CHECK(!step()); }

std::string Statement::text(int column) const {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_, column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  return bytes == nullptr ? std::string() : std::string(bytes, size);
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}

double Statement::real(int column) const { return sqlite3_column_double(statement_, column); }

Transaction::Transaction(Database& database) : database_(database) {
  database_.run("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  if (!open_) return;
  try {
    database_.run("ROLLBACK");
  } catch (const InputError&) {
    // The error that caused this is already being thrown.
  }
}

void Transaction::commit() {
  database_.run("COMMIT");
  open_ = false;
}

}  // namespace earpoint
