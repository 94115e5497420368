#include "test_clip.h"

#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>

#include <earpoint/error.h>
#include <earpoint/render/head_file.h>
#include <earpoint/serve/clip_server.h>
#include <earpoint/spatial/sofa_file.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

using nlohmann::json;

class ClipServerTest : public testing::Test {
 protected:
  void SetUp() override {
    port_ = server_.bind();
    thread_ = std::thread([this] { server_.run(); });
    client_ = std::make_unique<httplib::Client>("127.0.0.1", port_);
    client_->set_read_timeout(60);  // a busy machine may take long to open the clip
  }
  void TearDown() override {
    server_.stop();
    thread_.join();
  }

  std::string join() {
    const auto answer = client_->Post("/api/listeners", R"({"clip": "clip"})", "application/json");
    return answer && answer->status == 200
               ? json::parse(answer->body)["listener"].get<std::string>()
               : std::string();
  }
  httplib::Result ask(const std::string& listener, const std::string& body) {
    return client_->Post("/api/listeners/" + listener + "/sound", body, "application/json");
  }

  static ClipLibrary& library() {
    static ClipLibrary library;
    if (library.list().empty()) {
      library.add("clip", "clip.mp4", [] { return *bundled_clip(); });
      library.add("told", "clip.mp4, told", [] { return *told_clip(); });
    }
    return library;
  }

  ClipServer server_{library(), bundled_methods(), {.most_listeners = 2}};
  int port_ = 0;
  std::thread thread_;
  std::unique_ptr<httplib::Client> client_;
};

TEST_F(ClipServerTest, TellsTheClip) {
  const auto answer = client_->Get("/api/clips/clip");
  ASSERT_TRUE(answer);
  const json clip = json::parse(answer->body);
  EXPECT_EQ(clip["name"], "clip.mp4");
  EXPECT_EQ(clip["samples"], bundled_clip()->sound.samples());
  EXPECT_TRUE(clip["has_picture"]);
  EXPECT_TRUE(clip["has_movie"]);
  const json list = json::parse(client_->Get("/api/clips")->body);
  EXPECT_EQ(list["clips"][0]["id"], "clip");
  EXPECT_EQ(list["most_upload_bytes"], 0);
  EXPECT_EQ(client_->Get("/api/clips/other")->status, 404);
  // dsp and vigas have no speaker: the page says what they lack.
  EXPECT_FALSE(clip["methods"][0].contains("missing"));
  EXPECT_TRUE(clip["methods"][1].contains("missing"));
  EXPECT_TRUE(clip["methods"][3].contains("missing"));
  const auto picture = client_->Get("/api/clips/clip/picture");
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->body.substr(1, 3), "PNG");
}

TEST_F(ClipServerTest, SendsTheSoundThatAListenerAsksFor) {
  const std::string listener = join();
  ASSERT_EQ(listener.size(), 32U);
  const auto answer = ask(listener, R"({"start": 9000, "samples": 1000, "method": "input"})");
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->status, 200);
  ASSERT_EQ(answer->body.size(), 8000U);
  std::vector<float> samples(2000);
  std::memcpy(samples.data(), answer->body.data(), answer->body.size());
  const Waveform& sound = bundled_clip()->sound;
  for (std::size_t i = 0; i < 1000; ++i) {
    EXPECT_EQ(samples[2 * i], sound.channel(0)[9000 + i]);
    EXPECT_EQ(samples[2 * i + 1], sound.channel(1)[9000 + i]);
  }
}

TEST_F(ClipServerTest, SendsAllOfTheRecordingForPagesThatRender) {
  const auto answer = client_->Get("/api/clips/clip/sound");
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->status, 200);
  const Waveform& sound = bundled_clip()->sound;
  ASSERT_EQ(answer->body.size(), sound.planar().size_bytes());
  EXPECT_EQ(std::memcmp(answer->body.data(), sound.planar().data(), answer->body.size()), 0);
  EXPECT_EQ(client_->Get("/api/clips/other/sound")->status, 404);
}

TEST_F(ClipServerTest, SendsWhatAPagesEngineOpensForAMethod) {
  const auto bytes_of = [&](const std::string& method) {
    const auto answer = client_->Get("/api/model?method=" + method);
    return answer && answer->status == 200 ? answer->body : std::string();
  };
  const std::string network = bytes_of("gtf");
  std::ifstream file(EARPOINT_SOURCE_DIR "/models/gtf.safetensors", std::ios::binary);
  EXPECT_EQ(network, std::string(std::istreambuf_iterator<char>(file), {}));
  const std::string head = bytes_of("dsp");
  const SafetensorsFile parsed = parse_safetensors(std::as_bytes(std::span(head)), "head");
  ASSERT_TRUE(is_head_file(parsed));
  EXPECT_EQ(read_head_file(parsed, "head").responses, read_sofa(default_hrtf_path()).responses);
  // The recording needs nothing, and the engine cannot run the others. Nothing is read by its path.
  for (const char* method :
       {"input", "vigas", "magic", "", "..%2fgtf", "%2fetc%2fpasswd", "models%2fgtf.safetensors"}) {
    EXPECT_EQ(client_->Get(std::string("/api/model?method=") + method)->status, 404) << method;
  }
}

TEST_F(ClipServerTest, TellsPagesWhatTheyCanRender) {
  const json clip = json::parse(client_->Get("/api/clips/clip")->body);
  EXPECT_EQ(clip["methods"][0]["browser"], "recording");
  EXPECT_EQ(clip["methods"][1]["browser"], "model");
  EXPECT_EQ(clip["methods"][2]["browser"], "model");
  EXPECT_FALSE(clip["methods"][3].contains("browser"));
  // Only what the user or the data set has told; found speakers are for the eye alone.
  EXPECT_FALSE(clip.contains("speaker_m"));
  EXPECT_FALSE(clip.contains("speaker_box"));
  const json told = json::parse(client_->Get("/api/clips/told")->body);
  EXPECT_EQ(told["speaker_m"], json({1.89, 0.196, 0.147}));
  EXPECT_EQ(told["speaker_box"], json({0.383, 0.348, 0.513, 1.0}));
  EXPECT_EQ(json::parse(client_->Get("/api/clips")->body)["has_engine"], has_engine());
  EXPECT_EQ(client_->Get("/engine.wasm")->status, has_engine() ? 200 : 404);
  // WebAssembly may be compiled where there is some to compile; text never.
  const std::string policy = client_->Get("/")->get_header_value("Content-Security-Policy");
  EXPECT_EQ(policy.find("'wasm-unsafe-eval'") != std::string::npos, has_engine()) << policy;
  EXPECT_EQ(policy.find("'unsafe-eval'"), std::string::npos) << policy;
}

TEST_F(ClipServerTest, RefusesBadRequestsInALineAndGoesOn) {
  const std::string listener = join();
  for (const auto& [body, word] : std::vector<std::pair<std::string, std::string>>{
           {"nonsense", "JSON"},
           {R"({"start": -1, "samples": 10})", "start"},
           {R"({"start": 1e300, "samples": 10})", "start"},
           {R"({"start": 0, "samples": 1e9})", "samples"},
           {R"({"start": 0, "samples": 10, "position_m": [0, 0]})", "position_m"},
           {R"({"start": 0, "samples": 10, "position_m": [1e9, 0, 0]})", "position_m"},
           {R"({"start": 0, "samples": 10, "yaw_deg": "left"})", "yaw_deg"},
           {R"({"start": 0, "samples": 10, "method": "magic"})", "method"}}) {
    const auto answer = ask(listener, body);
    ASSERT_TRUE(answer) << body;
    EXPECT_EQ(answer->status, 400) << body;
    EXPECT_NE(answer->body.find(word), std::string::npos) << answer->body;
  }
  EXPECT_EQ(ask(listener, R"({"start": 0, "samples": 10})")->status, 200);
  EXPECT_EQ(ask(std::string(32, '0'), R"({"start": 0, "samples": 10})")->status, 404);
  const auto large = ask(listener, std::string(100000, ' '));
  EXPECT_TRUE(!large || large->status == 413);
}

TEST_F(ClipServerTest, HasRoomForSoManyListeners) {
  EXPECT_FALSE(join().empty());
  EXPECT_FALSE(join().empty());
  EXPECT_EQ(client_->Post("/api/listeners", R"({"clip": "clip"})", "application/json")->status,
            503);
}

TEST_F(ClipServerTest, AnswersNoPageOfAnotherSite) {
  const auto answer = client_->Get("/api/clips/clip", {{"Host", "elsewhere.example"}});
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 403);
}

TEST_F(ClipServerTest, ServesThePageAndNothingElse) {
  const auto page = client_->Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, has_page() ? 200 : 404);
  if (has_page()) {
    for (const char* file : {"/app.js", "/worklet.js", "/style.css"}) {
      EXPECT_EQ(client_->Get(file)->status, 200) << file;
      EXPECT_NE(page->body.find("app.js"), std::string::npos);
    }
  }
  for (const char* path : {"/../CMakeLists.txt", "/%2e%2e/etc/passwd", "/etc/passwd", "//app.js"}) {
    EXPECT_NE(client_->Get(path)->status, 200) << path;
  }
}

TEST_F(ClipServerTest, MakesRoomWhenAListenerLeaves) {
  const std::string first = join();
  EXPECT_FALSE(join().empty());
  EXPECT_EQ(client_->Post("/api/listeners/" + first + "/leave")->status, 200);
  EXPECT_FALSE(join().empty());
}

TEST_F(ClipServerTest, RendersAWalk) {
  std::string walk = "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n0,0,0,0,0,0,0\n";
  walk += fmt::format("{},1,0,0,0,0,0\n", bundled_clip()->sound.duration_s());
  const auto render = [&](const std::string& query, const std::string& csv) {
    return client_->Post("/api/clips/clip/walk?" + query, csv, "text/csv");
  };
  const auto answer = render("method=input&format=wav", walk);
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->status, 200) << answer->body;
  EXPECT_EQ(answer->body.substr(0, 4), "RIFF");
  // 32-bit samples of both ears, and a header.
  EXPECT_GE(answer->body.size(), 8U * static_cast<std::size_t>(bundled_clip()->sound.samples()));
  EXPECT_EQ(render("method=input&format=wav", "nonsense")->status, 400);
  EXPECT_EQ(render("method=magic&format=wav", walk)->status, 400);
  EXPECT_EQ(render("method=truth&format=wav", walk)->status, 400);
}

TEST(ClipServer, SaysThatAPortIsTaken) {
  ClipLibrary library;
  ClipServer first(library, bundled_methods(), {});
  const int port = first.bind();
  ClipServer second(library, bundled_methods(), {.address = {.port = port}});
  try {
    second.bind();
    ADD_FAILURE() << "port " << port << " was given twice";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(std::to_string(port)), std::string::npos);
  }
}

}  // namespace
}  // namespace earpoint
