// Requests of attackers and of broken clients: the server refuses them and goes on.
#include "test_clip.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include <earpoint/error.h>
#include <earpoint/serve/clip_server.h>

namespace earpoint {
namespace {

using nlohmann::json;

/// A server of one clip that runs while this lives.
class RunningServer {
 public:
  explicit RunningServer(ServeOptions options)
      : server_(library_, bundled_methods(), std::move(options)) {
    library_.add("clip", "clip.mp4", [] { return *bundled_clip(); });
    port_ = server_.bind();
    thread_ = std::thread([this] { server_.run(); });
  }
  ~RunningServer() {
    server_.stop();
    thread_.join();
  }
  RunningServer(const RunningServer&) = delete;
  RunningServer& operator=(const RunningServer&) = delete;

  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] httplib::Client client() const { return httplib::Client("127.0.0.1", port_); }
  ClipLibrary& library() { return library_; }

 private:
  ClipLibrary library_;
  ClipServer server_;
  int port_ = 0;
  std::thread thread_;
};

/// A connection that sends any bytes.
class RawConnection {
 public:
  explicit RawConnection(int port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
    is_open_ = connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~RawConnection() { close(socket_); }
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;

  [[nodiscard]] bool is_open() const { return is_open_; }
  void say(const std::string& text) const {
    (void)send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
  }
  /// Whether the other end has closed it.
  [[nodiscard]] bool is_closed() const {
    char byte = 0;
    const ssize_t count = recv(socket_, &byte, 1, MSG_DONTWAIT);
    return count == 0 || (count < 0 && errno != EAGAIN);
  }

 private:
  int socket_;
  bool is_open_ = false;
};

std::string join_as_listener(httplib::Client& client) {
  const auto answer = client.Post("/api/listeners", R"({"clip": "clip"})", "application/json");
  return json::parse(answer->body).value("listener", "");
}

/// Expects that a new client is answered soon.
void expect_answers(const RunningServer& server) {
  httplib::Client client = server.client();
  client.set_connection_timeout(20);
  client.set_read_timeout(20);
  const auto answer = client.Get("/api/clips");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200);
}

TEST(ServerSafety, AnswersOthersOnlyWithTheToken) {
  const std::string token(32, 'a');
  RunningServer server({.address = {.host = "0.0.0.0", .token = token}});
  httplib::Client client = server.client();
  EXPECT_EQ(client.Get("/api/clips")->status, 401);
  EXPECT_EQ(client.Get("/")->status, 401);
  EXPECT_EQ(client.Get("/api/clips/clip/sound")->status, 401);
  EXPECT_EQ(client.Get("/api/model?method=gtf")->status, 401);
  EXPECT_EQ(client.Get("/engine.wasm")->status, 401);
  EXPECT_EQ(client.Get("/?token=" + std::string(32, 'b'))->status, 401);
  EXPECT_EQ(client.Post("/api/listeners", R"({"clip": "clip"})", "application/json")->status, 401);
  const auto first = client.Get("/?token=" + token);
  EXPECT_EQ(first->status, 302);
  const std::string cookie = first->get_header_value("Set-Cookie");
  EXPECT_NE(cookie.find("HttpOnly"), std::string::npos);
  EXPECT_NE(cookie.find("SameSite=Strict"), std::string::npos);
  const httplib::Headers with{{"Cookie", "other=1; " + cookie.substr(0, cookie.find(';'))}};
  EXPECT_EQ(client.Get("/api/clips", with)->status, 200);
}

TEST(ServerSafety, ReachesOthersOnlyWithAToken) {
  ClipLibrary library;
  EXPECT_THROW(ClipServer(library, bundled_methods(), {.address = {.host = "0.0.0.0"}}),
               InputError);
}

TEST(ServerSafety, TakesNothingFromPagesOfOtherSites) {
  RunningServer server({});
  httplib::Client client = server.client();
  const std::string body = R"({"clip": "clip"})";
  const auto from = [&](const std::string& origin) {
    return client.Post("/api/listeners", {{"Origin", origin}}, body, "application/json")->status;
  };
  EXPECT_EQ(from("http://elsewhere.example"), 403);
  EXPECT_EQ(from("null"), 403);
  EXPECT_EQ(from(fmt::format("http://127.0.0.1:{}", server.port())), 200);
}

TEST(ServerSafety, AnswersBesideTwoHundredConnectionsThatSayNothingOrLittle) {
  RunningServer server({});
  std::vector<std::unique_ptr<RawConnection>> others;
  for (int i = 0; i < 200; ++i) {
    others.push_back(std::make_unique<RawConnection>(server.port()));
    ASSERT_TRUE(others.back()->is_open());
    if (i % 2 == 0) others.back()->say("GET /api/clips HT");
  }
  const auto began = std::chrono::steady_clock::now();
  expect_answers(server);
  // With fewer threads than connections this would take until they time out: 5 s or more.
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(4));
}

TEST(ServerSafety, CutsOffHeadersAndBodiesThatDrip) {
  PageServer server({.limits = {.grace = std::chrono::milliseconds(100)}});
  std::atomic<int> answered = 0;
  server.routes().Post("/take", [&](const httplib::Request&, httplib::Response&) { ++answered; });
  const int port = server.bind();
  std::thread thread([&] { server.run(); });
  for (const std::string start : {"POST /take HT", "POST /take HTTP/1.1\r\nHost: localhost\r\n",
                                  "POST /take HTTP/1.1\r\nHost: localhost\r\n"
                                  "Content-Length: 10000\r\n\r\n"}) {
    const RawConnection slow(port);
    slow.say(start);
    // A byte every 5 ms, so that no single wait is long. The server must close within a minute.
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!slow.is_closed() && std::chrono::steady_clock::now() < end) {
      slow.say("x");
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_TRUE(slow.is_closed()) << start;
  }
  EXPECT_EQ(answered, 0);
  // A fast client is answered. With so little grace a busy machine may need several tries.
  httplib::Client client("127.0.0.1", port);
  for (int i = 0; i < 100 && answered == 0; ++i) (void)client.Post("/take", "x", "text/plain");
  EXPECT_GE(answered, 1);
  server.stop();
  thread.join();
}

TEST(ServerSafety, TakesNoEndOfHeaders) {
  RunningServer server({});
  const RawConnection greedy(server.port());
  greedy.say("GET / HTTP/1.1\r\n");
  for (int i = 0; i < 10'000 && !greedy.is_closed(); ++i) {
    greedy.say(fmt::format("X-{}: {}\r\n", i, std::string(1000, 'x')));
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!greedy.is_closed() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_TRUE(greedy.is_closed());
  expect_answers(server);
}

TEST(ServerSafety, GoesOnAfterStreamsThatAreBrokenOff) {
  RunningServer server({});
  httplib::Client client = server.client();
  const std::string listener = join_as_listener(client);
  const std::string wish = R"({"start": 0, "samples": 48000, "method": "gtf"})";
  for (int i = 0; i < 20; ++i) {
    const RawConnection connection(server.port());
    connection.say(
        fmt::format("POST /api/listeners/{}/sound HTTP/1.1\r\nHost: localhost\r\n"
                    "Content-Length: {}\r\n\r\n{}",
                    listener, wish.size() + (i % 2 == 0 ? 0 : 100), wish));
  }
  const auto answer =
      client.Post("/api/listeners/" + listener + "/sound", wish, "application/json");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->body.size(), 8U * 48000U);
}

TEST(ServerSafety, ReadsNoFilesByTheirPaths) {
  RunningServer server({});
  httplib::Client client = server.client();
  for (const char* path :
       {"/../CMakeLists.txt", "/%2e%2e/%2e%2e/etc/passwd", "/etc/passwd", "//app.js",
        "/api/clips/../clip", "/api/clips/%2e%2e%2fclip", "/api/clips/clip/../../x",
        "/api/clips/clip%00", "/api/clips/../sound", "/api/model?method=%2fetc%2fpasswd"}) {
    const auto answer = client.Get(path);
    EXPECT_TRUE(!answer || answer->status >= 400) << path;
  }
  expect_answers(server);
}

TEST(ServerSafety, RefusesOtherMethodsFormsAndLargeBodies) {
  RunningServer server({.most_upload_bytes = 1U << 20U});
  httplib::Client client = server.client();
  EXPECT_EQ(client.Put("/api/clips", "x", "text/plain")->status, 405);
  EXPECT_EQ(client.Delete("/api/clips/clip")->status, 405);
  EXPECT_EQ(
      client.Post("/api/clips", httplib::MultipartFormDataItems{{"a", "b", "c", "d"}})->status,
      415);
  for (const char* path : {"/api/clips", "/api/clips/clip/walk?method=input", "/nowhere"}) {
    const auto answer = server.client().Post(path, std::string(8U << 20U, 'x'), "text/plain");
    EXPECT_TRUE(!answer || answer->status >= 400) << path;
  }
  expect_answers(server);
}

TEST(ServerSafety, GoesOnAfterDownloadsThatAreBrokenOff) {
  RunningServer server({});
  for (int i = 0; i < 20; ++i) {
    const RawConnection connection(server.port());
    connection.say(fmt::format("GET {} HTTP/1.1\r\nHost: localhost\r\n\r\n",
                               i % 2 == 0 ? "/api/clips/clip/sound" : "/api/model?method=gtf"));
  }
  const auto answer = server.client().Get("/api/clips/clip/sound");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->body.size(), bundled_clip()->sound.planar().size_bytes());
}

TEST(ServerSafety, TakesUploadsAsTheOpenerDoes) {
  ServeOptions options{.most_upload_bytes = 1U << 20U};
  options.open_upload = [](const std::filesystem::path& file, const std::string& name) {
    if (std::filesystem::file_size(file) != 5) throw InputError(name, "is not a movie");
    ServedClip clip;
    clip.name = name;
    clip.sound = Waveform(2, 16000, 16000);
    return clip;
  };
  RunningServer server(std::move(options));
  httplib::Client client = server.client();
  const auto taken = client.Post("/api/clips?name=m%C3%BCll.mp4", "movie", "video/mp4");
  ASSERT_EQ(taken->status, 200) << taken->body;
  const std::string id = json::parse(taken->body)["clip"];
  EXPECT_EQ(json::parse(client.Get("/api/clips/" + id)->body)["name"], "m\u00fcll.mp4");
  EXPECT_EQ(client.Get("/api/clips/" + id + "/sound")->body.size(), 8U * 16000U);
  const auto refused = client.Post("/api/clips?name=a.exe", "MZ", "video/mp4");
  EXPECT_EQ(refused->status, 400);
  EXPECT_EQ(json::parse(refused->body)["error"], "a.exe: is not a movie");
  // Only one clip is listed: only its sender knows the other's id.
  EXPECT_EQ(json::parse(client.Get("/api/clips")->body)["clips"].size(), 1U);
}

TEST(ServerSafety, KeepsItsMemoryOverTenThousandRequests) {
  const auto resident_mb = [] {
    std::ifstream file("/proc/self/statm");
    double size = 0.0;
    double resident = 0.0;
    file >> size >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1U << 20U);
  };
  RunningServer server({});
  httplib::Client client = server.client();
  client.set_keep_alive(true);
  client.set_tcp_nodelay(true);
  const std::string listener = join_as_listener(client);
  const auto ask = [&](int count) {
    for (int i = 0; i < count; ++i) {
      const std::string body = fmt::format(
          R"({{"start": {}, "samples": 64, "method": "input", "position_m": [0, {}, 0]}})", i * 8,
          i * 1e-4);
      const auto answer =
          client.Post("/api/listeners/" + listener + "/sound", body, "application/json");
      ASSERT_TRUE(answer);
      ASSERT_EQ(answer->status, 200) << answer->body;
    }
  };
  ask(1000);
  const double before_mb = resident_mb();
  ask(10000);
  // A leak of a kilobyte per request would be 10 MB; allocators keep some memory.
  EXPECT_LT(resident_mb() - before_mb, 5.0);
}

}  // namespace
}  // namespace earpoint
