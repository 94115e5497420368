#include "test_study.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <map>
#include <thread>

#include <httplib.h>
#include <nlohmann/json.hpp>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/study/simulated_participant.h>
#include <earpoint/study/study_desk.h>
#include <earpoint/study/study_report.h>
#include <earpoint/study/study_server.h>

namespace earpoint {
namespace {

using nlohmann::json;

/// A study that is being served.
class ServedStudy {
 public:
  explicit ServedStudy(StudyDesign design) {
    study = copy_test_study(folder.path(), design);
    server = std::make_unique<StudyServer>(folder.path() / "study");
    port = server->bind();
    thread = std::thread([this] { server->run(); });
  }
  ~ServedStudy() {
    server->stop();
    thread.join();
  }
  [[nodiscard]] std::vector<StudyGroup> results() const {
    const auto place = folder.path() / "study";
    return study_results(study, AnswerStore::open_to_read(place / kAnswersFile,
                                                          read_text_file(place / "study.json")));
  }

  TestFolder folder;
  Study study;
  std::unique_ptr<StudyServer> server;
  int port = 0;
  std::thread thread;
};

/// The first number of the first row.
int number_in(const std::filesystem::path& file, const std::string& query) {
  sqlite3* database = nullptr;
  sqlite3_open_v2(file.c_str(), &database, SQLITE_OPEN_READONLY, nullptr);
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database, query.c_str(), -1, &statement, nullptr);
  const int number = sqlite3_step(statement) == SQLITE_ROW ? sqlite3_column_int(statement, 0) : -1;
  sqlite3_finalize(statement);
  sqlite3_close(database);
  return number;
}

TEST(StudyServer, ThreeSimulatedParticipantsGoThroughTheStudy) {
  ServedStudy served(StudyDesign::choice);
  std::vector<std::thread> participants;
  for (const SimulatedRule rule :
       {SimulatedRule::mag, SimulatedRule::level, SimulatedRule::random}) {
    participants.emplace_back([&served, rule] {
      const SimulatedOutcome outcome = take_part(served.port, {.rule = rule});
      EXPECT_TRUE(outcome.passed_headphones);
      EXPECT_EQ(outcome.answers, 6 + 1 + 8);
    });
  }
  for (std::thread& participant : participants) participant.join();

  const std::vector<StudyGroup> groups = served.results();
  ASSERT_EQ(groups.size(), 3U);
  std::map<std::string, const StudyGroup*> by_name;
  for (const StudyGroup& group : groups) {
    EXPECT_TRUE(group.is_simulated);
    by_name[group.name] = &group;
  }
  // The choices of the participant with rule Mag follow from study.json: it was given the right
  // sounds.
  std::map<std::string, double> expected;
  for (const StudyClip& clip : served.study.clips) {
    if (clip.is_control) continue;
    const auto best = std::ranges::min_element(clip.sounds, {}, &StudySound::mag);
    expected[best->condition] += 1.0 / 6.0;
  }
  for (const StudyRow& row : by_name.at("simulated: mag")->rows) {
    EXPECT_NEAR(row.value->value, expected[row.condition], 1e-9) << row.condition;
  }
  EXPECT_EQ(by_name.at("simulated: mag")->counted, 1U);
  EXPECT_EQ(by_name.at("simulated: level")->counted, 1U);

  // The report's numbers equal those in the database.
  const auto file = served.folder.path() / "study" / kAnswersFile;
  EXPECT_EQ(number_in(file, "SELECT count(*) FROM answers"), 3 * 15);
  EXPECT_EQ(number_in(file, "SELECT count(*) FROM participants WHERE simulated != ''"), 3);
  for (const StudyRow& row : by_name.at("simulated: random")->rows) {
    const int chosen = number_in(
        file, fmt::format("SELECT count(*) FROM answers JOIN participants ON participant = id "
                          "WHERE simulated = 'random' AND step > 6 AND "
                          "json_extract(plan, '$[' || step || '].item') NOT LIKE 'control%' AND "
                          "json_extract(content, '$.condition') = '{}'",
                          row.condition));
    // A random participant may miss a control and then counts only before screening.
    EXPECT_NEAR(row.before_screening->value, chosen / 6.0, 1e-9) << row.condition;
  }
}

TEST(StudyServer, RatesInTheOtherDesign) {
  ServedStudy served(StudyDesign::mushra);
  take_part(served.port, {.rule = SimulatedRule::mag});
  take_part(served.port, {.rule = SimulatedRule::mag});
  const StudyGroup group = served.results().at(0);
  EXPECT_EQ(group.counted, 2U);
  EXPECT_EQ(group.answers, 2U * 2U * 6U);
  for (const StudyRow& row : group.rows) {
    if (row.condition == kTruthCondition) {
      EXPECT_DOUBLE_EQ(row.value->value, 100.0);
    } else {
      EXPECT_LT(row.value->value, 90.0) << row.condition;
    }
  }
}

TEST(StudyServer, LoudspeakersFailTheHeadphoneCheck) {
  ServedStudy served(StudyDesign::choice);
  const SimulatedOutcome outcome =
      take_part(served.port, {.rule = SimulatedRule::mag, .has_loudspeakers = true});
  EXPECT_FALSE(outcome.passed_headphones);
  EXPECT_EQ(outcome.answers, 6);
  const StudyGroup group = served.results().at(0);
  EXPECT_EQ(group.counted, 0U);
  EXPECT_FALSE(group.rows[0].value);
}

TEST(StudyServer, TakesAnAnswerOnceHoweverOftenItIsSentAtOnce) {
  ServedStudy served(StudyDesign::choice);
  httplib::Client client("127.0.0.1", served.port);
  const std::string id = json::parse(client.Post("/api/participants")->body)["participant"];
  std::atomic<int> taken = 0;
  std::atomic<int> refused = 0;
  std::vector<std::thread> tabs;
  for (int i = 0; i < 8; ++i) {
    tabs.emplace_back([&] {
      httplib::Client tab("127.0.0.1", served.port);
      const auto answer = tab.Post("/api/participants/" + id + "/steps/0",
                                   R"({"choice": 1, "revision": 0})", "application/json");
      if (answer && answer->status == 200) ++taken;
      if (answer && answer->status == 409) ++refused;
    });
  }
  for (std::thread& tab : tabs) tab.join();
  EXPECT_EQ(taken, 1);
  EXPECT_EQ(refused, 7);
}

/// A server in a process of its own, as `earpoint study serve` is.
class ServerProcess {
 public:
  explicit ServerProcess(const std::filesystem::path& study) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    child_ = ::fork();
    if (child_ == 0) {
      StudyServer server(study);
      const int port = server.bind();
      EXPECT_EQ(::write(ends[1], &port, sizeof(port)), static_cast<ssize_t>(sizeof(port)));
      server.run();
      ::_exit(0);
    }
    EXPECT_EQ(::read(ends[0], &port_, sizeof(port_)), static_cast<ssize_t>(sizeof(port_)));
    ::close(ends[0]);
    ::close(ends[1]);
  }
  ~ServerProcess() {
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  [[nodiscard]] int port() const { return port_; }

 private:
  pid_t child_ = 0;
  int port_ = 0;
};

TEST(StudyServer, EveryAnswerThatWasTakenOutlivesAKill) {
  const TestFolder folder;
  copy_test_study(folder.path(), StudyDesign::choice);
  const std::filesystem::path place = folder.path() / "study";
  std::string self;
  int taken = 0;
  // Killed right after every other answer.
  for (int life = 0; life < 3; ++life) {
    ServerProcess process(place);
    httplib::Client client("127.0.0.1", process.port());
    if (self.empty()) {
      const auto joined = client.Post("/api/participants");
      ASSERT_TRUE(joined);
      self = "/api/participants/" + json::parse(joined->body)["participant"].get<std::string>();
    }
    const auto state = client.Get(self);
    ASSERT_TRUE(state);
    EXPECT_EQ(json::parse(state->body)["at"], taken);
    for (int i = 0; i < 2; ++i) {
      const auto answer = client.Post(fmt::format("{}/steps/{}", self, taken),
                                      R"({"choice": 1, "revision": 0})", "application/json");
      ASSERT_TRUE(answer);
      ASSERT_EQ(answer->status, 200);
      ++taken;
    }
  }
  EXPECT_EQ(number_in(place / kAnswersFile, "SELECT count(*) FROM answers"), taken);
}

TEST(StudyServer, ServesTheStudyAndNothingElse) {
  ServedStudy served(StudyDesign::choice);
  httplib::Client client("127.0.0.1", served.port);
  EXPECT_EQ(client.Get("/")->status, has_study_page() ? 200 : 404);
  const std::string id = json::parse(client.Post("/api/participants")->body)["participant"];
  const std::string self = "/api/participants/" + id;
  const auto sound = client.Get(self + "/steps/7/sounds/reference");
  EXPECT_EQ(sound->body.substr(0, 4), "RIFF");
  EXPECT_EQ(client.Get(self + "/steps/7/picture")->body.substr(1, 3), "PNG");
  for (const std::string& path :
       {self + "/steps/7/sounds/..%2f..%2fstudy.json", self + "/steps/7/sounds/truth",
        self + "/steps/99/picture", self + "/steps/99999/picture", std::string("/study.json"),
        std::string("/../study.json"), std::string("/answers.sqlite"),
        std::string("/clips/01/reference.wav"), "/api/participants/" + std::string(32, '0')}) {
    EXPECT_EQ(client.Get(path)->status, 404) << path;
  }
  EXPECT_EQ(client.Get("/", {{"Host", "elsewhere.example"}})->status, 403);
  const auto large = client.Post(self + "/steps/0", std::string(100000, ' '), "application/json");
  EXPECT_TRUE(!large || large->status == 413);
  EXPECT_THROW(StudyServer(served.folder.path()), InputError);  // holds no study
  StudyServer other(served.folder.path() / "study", {.port = served.port});
  EXPECT_THROW(other.bind(), InputError);
}

TEST(StudyServer, TakesParticipantsOfOtherComputersWithTheTokenAlone) {
  const TestFolder folder;
  copy_test_study(folder.path(), StudyDesign::choice);
  const std::filesystem::path place = folder.path() / "study";
  EXPECT_THROW(StudyServer(place, {.host = "0.0.0.0"}), InputError);
  const std::string token(32, 'a');
  StudyServer server(place, {.host = "0.0.0.0", .token = token});
  const int port = server.bind();
  std::thread thread([&] { server.run(); });
  httplib::Client client("127.0.0.1", port);
  for (const char* path : {"/", "/api/study", "/?token=b"}) {
    EXPECT_EQ(client.Get(path)->status, 401) << path;
  }
  EXPECT_EQ(client.Post("/api/participants")->status, 401);
  // The token becomes a cookie; the participant's code stays in the address.
  const auto first = client.Get("/?token=" + token + "&participant=p7");
  EXPECT_EQ(first->status, 302);
  EXPECT_EQ(first->get_header_value("Location"), "/?participant=p7");
  const std::string cookie = first->get_header_value("Set-Cookie");
  const httplib::Headers with{{"Cookie", cookie.substr(0, cookie.find(';'))}};
  EXPECT_EQ(client.Get("/api/study", with)->status, 200);
  server.stop();
  thread.join();
}

}  // namespace
}  // namespace earpoint
