#include <earpoint/study/answer_store.h>

#include "sqlite.h"

#include <array>
#include <ctime>
#include <random>
#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {

namespace fs = std::filesystem;

struct AnswerStore::State {
  State(const fs::path& file, bool to_read) : database(file, to_read) {}
  mutable Database database;
};

namespace {

constexpr const char* kTables = R"(
CREATE TABLE IF NOT EXISTS study (text TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS participants (
  id TEXT PRIMARY KEY,
  number INTEGER NOT NULL UNIQUE,
  label TEXT NOT NULL,
  simulated TEXT NOT NULL,
  plan TEXT NOT NULL,
  begun TEXT NOT NULL,
  finished TEXT NOT NULL DEFAULT '',
  passed_headphones INTEGER NOT NULL DEFAULT 1,
  comment TEXT NOT NULL DEFAULT '');
CREATE TABLE IF NOT EXISTS answers (
  participant TEXT NOT NULL REFERENCES participants (id),
  step INTEGER NOT NULL,
  revision INTEGER NOT NULL,
  content TEXT NOT NULL,
  seconds REAL NOT NULL,
  received TEXT NOT NULL,
  PRIMARY KEY (participant, step, revision));
)";

constexpr const char* kParticipantColumns =
    "id, number, label, simulated, plan, begun, finished, passed_headphones, comment";

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

/// 128 bits from the operating system.
std::string unguessable_id() {
  std::random_device device;
  std::string id;
  for (int i = 0; i < 4; ++i) id += fmt::format("{:08x}", device());
  return id;
}

Participant participant_of(const Statement& row) {
  return {.id = row.text(0),
          .number = static_cast<int>(row.integer(1)),
          .label = row.text(2),
          .simulated = row.text(3),
          .plan = row.text(4),
          .begun = row.text(5),
          .finished = row.text(6),
          .passed_headphones = row.integer(7) != 0,
          .comment = row.text(8)};
}

void check_study(Database& database, const std::string& study) {
  Statement stored(database, "SELECT text FROM study");
  if (!stored.step()) throw InputError(database.name(), "holds no study's answers");
  if (stored.text(0) == study) return;
  throw InputError(database.name(), "holds answers to another study, or study.json was changed",
                   "put the study.json back, or move these answers away");
}

}  // namespace

AnswerStore::AnswerStore(const fs::path& file, const std::string& study)
    : state_(std::make_unique<State>(file, false)) {
  Database& database = state_->database;
  // A commit is written to the disk, not only to the operating system.
  database.run("PRAGMA journal_mode = WAL");
  database.run("PRAGMA synchronous = FULL");
  database.run("PRAGMA foreign_keys = ON");
  Transaction transaction(database);
  database.run(kTables);
  if (!Statement(database, "SELECT 1 FROM study").step()) {
    Statement(database, "INSERT INTO study VALUES (?)").bind(study).run();
  }
  transaction.commit();
  check_study(database, study);
}

AnswerStore::AnswerStore(std::unique_ptr<State> state) : state_(std::move(state)) {}
AnswerStore::~AnswerStore() = default;
AnswerStore::AnswerStore(AnswerStore&&) noexcept = default;
AnswerStore& AnswerStore::operator=(AnswerStore&&) noexcept = default;

AnswerStore AnswerStore::open_to_read(const fs::path& file, const std::string& study) {
  if (!fs::is_regular_file(file)) {
    throw InputError(file.string(), "does not exist: nobody has taken part yet",
                     "start the study with earpoint study serve");
  }
  auto state = std::make_unique<State>(file, true);
  check_study(state->database, study);
  return AnswerStore(std::move(state));
}

std::optional<Participant> AnswerStore::add(const std::string& label, const std::string& simulated,
                                            const std::function<std::string(int)>& plan) {
  Database& database = state_->database;
  Transaction transaction(database);
  if (!label.empty() &&
      Statement(database, "SELECT 1 FROM participants WHERE label = ? AND passed_headphones")
          .bind(label)
          .step()) {
    return std::nullopt;
  }
  Statement last(database, "SELECT coalesce(max(number), 0) FROM participants");
  last.step();
  Participant participant{.id = unguessable_id(),
                          .number = static_cast<int>(last.integer(0)) + 1,
                          .label = label,
                          .simulated = simulated,
                          .plan = {},
                          .begun = now_utc(),
                          .finished = {},
                          .comment = {}};
  participant.plan = plan(participant.number);
  Statement(database,
            "INSERT INTO participants (id, number, label, simulated, plan, begun) "
            "VALUES (?, ?, ?, ?, ?, ?)")
      .bind(participant.id)
      .bind(participant.number)
      .bind(label)
      .bind(simulated)
      .bind(participant.plan)
      .bind(participant.begun)
      .run();
  transaction.commit();
  return participant;
}

std::optional<Participant> AnswerStore::find(std::string_view id) const {
  Statement row(state_->database,
                fmt::format("SELECT {} FROM participants WHERE id = ?", kParticipantColumns));
  if (!row.bind(id).step()) return std::nullopt;
  return participant_of(row);
}

std::vector<Participant> AnswerStore::participants() const {
  Statement row(state_->database,
                fmt::format("SELECT {} FROM participants ORDER BY number", kParticipantColumns));
  std::vector<Participant> all;
  while (row.step()) all.push_back(participant_of(row));
  return all;
}

bool AnswerStore::add_answer(const std::string& participant, int step, int revision,
                             const std::string& content, double seconds) {
  Database& database = state_->database;
  Transaction transaction(database);
  Statement next(database,
                 "SELECT coalesce(max(revision), -1) + 1 FROM answers "
                 "WHERE participant = ? AND step = ?");
  next.bind(participant).bind(step).step();
  if (next.integer(0) != revision) return false;
  Statement(database, "INSERT INTO answers VALUES (?, ?, ?, ?, ?, ?)")
      .bind(participant)
      .bind(step)
      .bind(revision)
      .bind(content)
      .bind(seconds)
      .bind(now_utc())
      .run();
  transaction.commit();
  return true;
}

std::vector<Answer> AnswerStore::answers(const std::string& participant, bool all_revisions) const {
  Statement row(state_->database,
                "SELECT step, revision, content, seconds, received FROM answers "
                "WHERE participant = ? ORDER BY step, revision");
  row.bind(participant);
  std::vector<Answer> all;
  while (row.step()) {
    Answer answer{.step = static_cast<int>(row.integer(0)),
                  .revision = static_cast<int>(row.integer(1)),
                  .content = row.text(2),
                  .seconds = row.real(3),
                  .received = row.text(4)};
    if (!all_revisions && !all.empty() && all.back().step == answer.step) all.pop_back();
    all.push_back(std::move(answer));
  }
  return all;
}

void AnswerStore::fail_headphones(const std::string& participant) {
  Statement(state_->database, "UPDATE participants SET passed_headphones = 0 WHERE id = ?")
      .bind(participant)
      .run();
}

bool AnswerStore::finish(const std::string& participant, const std::string& comment) {
  Database& database = state_->database;
  Statement(database,
            "UPDATE participants SET finished = ?, comment = ? WHERE id = ? AND finished = ''")
      .bind(now_utc())
      .bind(comment)
      .bind(participant)
      .run();
  return database.changes() == 1;
}

}  // namespace earpoint
