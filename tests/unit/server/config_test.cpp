// The configuration: what is read from where, who wins, and what each mistake is called.
#include "server/config.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "server/config_keys.h"

namespace culld::server {
namespace {

Result<Config> configOf(const std::string& text, const std::string& path = "culld.toml") {
  auto settings = settingsOfFile(text, path);
  if (!settings) return settings.error();
  return merged({settings.value()});
}

TEST(Config, HasTheDocumentedDefaultsWithoutAnySource) {
  const auto config = merged({});
  ASSERT_TRUE(config.ok());
  EXPECT_EQ(config.value().listen, "127.0.0.1:7420");
  EXPECT_EQ(config.value().limits.max_connections, ServerLimits().max_connections);
  EXPECT_TRUE(config.value().origins.empty());
}

TEST(Config, ReadsEveryKindOfValue) {
  const auto config = configOf(R"(
    listen = "[::1]:0"
    unix = "run/culld.sock"
    data = "/var/lib/culld"
    threads = 3
    [log]
    format = "json"
    level = "debug"
    [limits]
    max_connections = 7
    idle_timeout_s = 90
    hello_timeout_s = 0.25
    [tls]
    certificate = "cert.pem"
    key = "/etc/key.pem"
    [access]
    tokens = "../tokens.toml"
    origins = ["https://a.example", "https://b.example:8443"]
    unix_users = ["culld", 1000]
    allow_public = true
    [scenes]
    city = "city.glb"
    "dot.ted" = "/srv/x.glb"
  )",
                               "/etc/culld/culld.toml");
  ASSERT_TRUE(config.ok()) << config.error().message;
  const Config& c = config.value();
  EXPECT_EQ(c.listen, "[::1]:0");
  EXPECT_EQ(c.unix_path, "/etc/culld/run/culld.sock");
  EXPECT_EQ(c.data_folder, "/var/lib/culld");
  EXPECT_EQ(c.threads, 3U);
  EXPECT_EQ(c.log.format, LogFormat::kJson);
  EXPECT_EQ(c.log.level, LogLevel::kDebug);
  EXPECT_EQ(c.limits.max_connections, 7U);
  EXPECT_EQ(c.limits.session.idle_timeout.count(), 90'000);
  EXPECT_EQ(c.limits.session.hello_timeout.count(), 250);
  EXPECT_EQ(c.tls.certificate_file, "/etc/culld/cert.pem");
  EXPECT_EQ(c.tls.key_file, "/etc/key.pem");
  EXPECT_EQ(c.access.tokens_file, "/etc/culld/../tokens.toml");
  EXPECT_EQ(c.access.origins,
            (std::vector<std::string>{"https://a.example", "https://b.example:8443"}));
  EXPECT_EQ(c.access.unix_users, (std::vector<std::string>{"culld", "1000"}));
  EXPECT_TRUE(c.access.allow_public);
  EXPECT_EQ(c.scenes.at("city"), "/etc/culld/city.glb");
  EXPECT_EQ(c.scenes.at("dot.ted"), "/srv/x.glb");
  EXPECT_EQ(c.origins.at("threads"), "/etc/culld/culld.toml:5");
}

TEST(Config, LetsFlagsWinOverTheEnvironmentAndThatOverTheFile) {
  const auto file = settingsOfFile(
      "listen = \"127.0.0.1:1\"\nthreads = 1\n[log]\nlevel = \"error\"\n[scenes]\na = \"f\"\nb = "
      "\"f\"",
      "f.toml");
  const auto environment =
      settingsOfEnvironment({"CULLD_THREADS=2", "CULLD_LISTEN=127.0.0.1:2", "PATH=/bin"});
  const auto flags = settingsOfFlags({{"listen", "127.0.0.1:3"}, {"scenes", "b=g"}});
  ASSERT_TRUE(file.ok() && environment.ok() && flags.ok());
  const auto config = merged({file.value(), environment.value(), flags.value()});
  ASSERT_TRUE(config.ok());
  EXPECT_EQ(config.value().listen, "127.0.0.1:3");
  EXPECT_EQ(config.value().threads, 2U);
  EXPECT_EQ(config.value().log.level, LogLevel::kError);
  EXPECT_EQ(config.value().scenes, (std::map<std::string, std::string>{{"a", "f"}, {"b", "g"}}));
  EXPECT_EQ(config.value().origins,
            (std::map<std::string, std::string>{{"listen", "--listen"},
                                                {"threads", "CULLD_THREADS"},
                                                {"log.level", "f.toml:4"},
                                                {"scenes.a", "f.toml:6"},
                                                {"scenes.b", "--scene"}}));
}

TEST(Config, ReadsEveryKindOfValueFromTheEnvironment) {
  const auto settings =
      settingsOfEnvironment({"CULLD_LIMITS_MAX_VIEWS=5", "CULLD_LIMITS_DRAIN_TIMEOUT_S=1.5",
                             "CULLD_ACCESS_ALLOW_PUBLIC=true",
                             "CULLD_ACCESS_ORIGINS=https://a,https://b", "CULLD_TLS_KEY=key.pem"});
  ASSERT_TRUE(settings.ok()) << settings.error().message;
  const auto config = merged({settings.value()});
  ASSERT_TRUE(config.ok());
  EXPECT_EQ(config.value().limits.session.max_views, 5U);
  EXPECT_EQ(config.value().limits.drain_timeout.count(), 1500);
  EXPECT_TRUE(config.value().access.allow_public);
  EXPECT_EQ(config.value().access.origins, (std::vector<std::string>{"https://a", "https://b"}));
  EXPECT_EQ(config.value().tls.key_file, "key.pem");  // as for a flag: from where it runs
}

struct Mistake {
  const char* text;
  const char* line;  ///< the whole message
};

TEST(Config, NamesThePlaceOfEachMistakeInAFile) {
  const Mistake kMistakes[] = {
      // Keys that are none, with the nearest that is.
      {"lisen = \"x\"", "culld.toml:1: lisen is not known; did you mean listen?"},
      {"\n\nmax_connections = 4",
       "culld.toml:3: max_connections is not known; did you mean limits.max_connections?"},
      {"[limits]\nmax_conections = 4",
       "culld.toml:2: limits.max_conections is not known; did you mean limits.max_connections?"},
      {"[limit]\nmax_views = 1", "culld.toml:1: limit is not known; did you mean limits?"},
      {"[log]\nlisten = \"x\"", "culld.toml:2: log.listen is not known; did you mean listen?"},
      {"frobnicate = 1", "culld.toml:1: frobnicate is not known"},
      {"\"\" = 1", "culld.toml:1:  is not known"},
      {"a.b.c = 1", "culld.toml:1: a is not known"},
      // Values of another kind.
      {"listen = 5", "culld.toml:1: listen: a whole number where a text belongs"},
      {"listen = {}", "culld.toml:1: listen: a table where a text belongs"},
      {"[listen]\nx = 1", "culld.toml:1: listen: a table where a text belongs"},
      {"limits = 4", "culld.toml:1: limits: a whole number where a table belongs"},
      {"[[limits]]", "culld.toml:1: limits: a list where a table belongs"},
      {"threads = \"2\"", "culld.toml:1: threads: a text where a whole number belongs"},
      {"threads = 2.5", "culld.toml:1: threads: a number where a whole number belongs"},
      {"threads = true", "culld.toml:1: threads: true or false where a whole number belongs"},
      {"threads = 1979-05-27",
       "culld.toml:1: threads: a date or time where a whole number belongs"},
      {"[limits]\nidle_timeout_s = \"1 min\"",
       "culld.toml:2: limits.idle_timeout_s: a text where a number belongs"},
      {"[access]\norigins = \"x\"",
       "culld.toml:2: access.origins: a text where a list of texts belongs"},
      {"[access]\nunix_users = [[]]",
       "culld.toml:2: access.unix_users: a list where a list of texts belongs"},
      {"[access]\nallow_public = 1",
       "culld.toml:2: access.allow_public: a whole number where true or false belongs"},
      {"[scenes]\na = 3", "culld.toml:2: scenes.a: a whole number where a path belongs"},
      // Values that cannot be.
      {"listen = \"foo:1\"", "culld.toml:1: listen = \"foo:1\": foo is not an IP address"},
      {"listen = \"127.0.0.1:65536\"", "culld.toml:1: listen = \"127.0.0.1:65536\": not HOST:PORT"},
      {"listen = \"a\\nb\"", "culld.toml:1: listen = \"a\\nb\": not HOST:PORT"},
      {"unix = \"\"", "culld.toml:1: unix = \"\": is empty"},
      {"data = \"a\\u0000b\"", "culld.toml:1: data = \"a\\u0000b\": holds a null character"},
      {"threads = -1", "culld.toml:1: threads = -1: is not from 0 to 1024"},
      {"threads = 1025", "culld.toml:1: threads = 1025: is not from 0 to 1024"},
      {"backend = \"gpu\"",
       "culld.toml:1: backend = \"gpu\": is none of auto, cpu, "
       "egl-device[:n], egl-surfaceless, osmesa"},
      {"[log]\nlevel = \"infos\"",
       "culld.toml:2: log.level = \"infos\": is none of debug, info, warning, error"},
      {"[limits]\nmax_views = 0", "culld.toml:2: limits.max_views = 0: is not from 1 to 64"},
      {"[limits]\nidle_timeout_s = nan",
       "culld.toml:2: limits.idle_timeout_s = nan: is not from 0.001 to 86400"},
      {"[limits]\nidle_timeout_s = inf",
       "culld.toml:2: limits.idle_timeout_s = inf: is not from 0.001 to 86400"},
      {"[access]\norigins = [\"\"]", "culld.toml:2: access.origins = [\"\"]: holds an empty text"},
      {"[scenes]\n\"a/b\" = \"x\"", "culld.toml:2: scenes.a/b: name is not [A-Za-z0-9._-]{1,64}"},
      {"[scenes]\na = \"\"", "culld.toml:2: scenes.a = \"\": is empty"},
  };
  for (const Mistake& mistake : kMistakes) {
    const auto config = configOf(mistake.text);
    ASSERT_FALSE(config.ok()) << mistake.text;
    EXPECT_EQ(config.error().message, mistake.line);
    EXPECT_EQ(config.error().code, ErrorCode::kInvalidInput);
  }
}

TEST(Config, NamesTheLineOfTextThatIsNoToml) {
  for (const char* text :
       {"\na = [", "\nlisten", "\nlisten = ", "\n= 1", "\n[log", "\n\"x",
        "\nthreads = 99999999999999999999", "\nthreads = 1 2", "\n\x01", "\nlisten = \"\xff\""}) {
    const auto config = configOf(text);
    ASSERT_FALSE(config.ok()) << text;
    EXPECT_EQ(config.error().message.rfind("culld.toml:2: ", 0), 0U) << config.error().message;
  }
  const auto twice = configOf("threads = 1\nthreads = 2");
  ASSERT_FALSE(twice.ok());
  EXPECT_EQ(twice.error().message.rfind("culld.toml:2: ", 0), 0U) << twice.error().message;
}

TEST(Config, NamesFilesThatCannotBeRead) {
  const std::filesystem::path folder = ::testing::TempDir();
  EXPECT_EQ(settingsOfFile(folder.string()).error().message,
            folder.string() + ": is no regular file");
  const std::string none = (folder / "none.toml").string();
  EXPECT_EQ(settingsOfFile(none).error().message,
            none + ": cannot open: No such file or directory");
  const std::string large = (folder / "large.toml").string();
  std::ofstream(large) << std::string((std::size_t{1} << 20) + 1, '#');
  EXPECT_EQ(settingsOfFile(large).error().message, large + ": larger than 1048576 bytes");
  std::ofstream(large) << std::string(std::size_t{1} << 20, '#');
  EXPECT_TRUE(settingsOfFile(large).ok());
  std::filesystem::remove(large);
}

TEST(Config, NamesTheVariableOfEachMistakeInTheEnvironment) {
  const auto message = [](const std::string& entry) {
    const auto settings = settingsOfEnvironment({entry});
    if (!settings) return settings.error().message;
    const auto config = merged({settings.value()});
    return config.ok() ? "fine" : config.error().message;
  };
  EXPECT_EQ(message("CULLD_THREADS=x"), "CULLD_THREADS=x: not a whole number");
  EXPECT_EQ(message("CULLD_THREADS=2 "), "CULLD_THREADS=2 : not a whole number");
  EXPECT_EQ(message("CULLD_THREADS=-1"), "CULLD_THREADS=-1: is not from 0 to 1024");
  EXPECT_EQ(message("CULLD_LIMITS_IDLE_TIMEOUT_S=soon"),
            "CULLD_LIMITS_IDLE_TIMEOUT_S=soon: not a number");
  EXPECT_EQ(message("CULLD_ACCESS_ALLOW_PUBLIC=yes"),
            "CULLD_ACCESS_ALLOW_PUBLIC=yes: not true or false");
  EXPECT_EQ(message("CULLD_UNIX="), "CULLD_UNIX=: is empty");
  EXPECT_EQ(message("CULLD_LISTN=127.0.0.1:1"),
            "CULLD_LISTN is not known; did you mean CULLD_LISTEN?");
  EXPECT_EQ(message("CULLD_TOKEN=secret"), "fine");  // cullctl's
  EXPECT_EQ(message("CULLD_"), "fine");
  EXPECT_EQ(message("=x"), "fine");
}

TEST(Config, NamesTheFlagOfEachMistakeOnTheCommandLine) {
  const auto message = [](const std::string& key, const std::string& text) {
    const auto settings = settingsOfFlags({{key, text}});
    if (!settings) return settings.error().message;
    const auto config = merged({settings.value()});
    return config.ok() ? "fine" : config.error().message;
  };
  EXPECT_EQ(message("listen", "nowhere"), "--listen nowhere: not HOST:PORT");
  EXPECT_EQ(message("threads", "many"), "--threads many: not a whole number");
  EXPECT_EQ(message("log.level", "loud"),
            "--log-level loud: is none of debug, info, warning, error");
  EXPECT_EQ(message("scenes", "x"), "--scene x: not NAME=FILE");
  EXPECT_EQ(message("scenes", "x="), "--scene x=: not NAME=FILE");
  EXPECT_EQ(settingsOfFlags({{"scenes", "x=a"}, {"scenes", "x=b"}}).error().message,
            "--scene x=b: the name x is given twice");
  EXPECT_EQ(message("unix", std::string(200, 'x')),
            "--unix " + std::string(200, 'x') + ": path too long for a socket");
}

TEST(Config, PrintsAFileThatSaysTheSame) {
  const auto flags = settingsOfFlags({{"listen", "127.0.0.1:1"}, {"scenes", "a.b=x y.glb"}});
  const auto environment = settingsOfEnvironment({"CULLD_DATA=a \"quoted\" \\ folder\x7f",
                                                  "CULLD_ACCESS_ORIGINS=https://a,https://b",
                                                  "CULLD_LIMITS_HELLO_TIMEOUT_S=0.125"});
  ASSERT_TRUE(flags.ok() && environment.ok());
  const auto config = merged({environment.value(), flags.value()});
  ASSERT_TRUE(config.ok());
  const std::string printed = describe(config.value());
  EXPECT_NE(printed.find("listen = \"127.0.0.1:1\"                            # --listen\n"),
            std::string::npos)
      << printed;
  EXPECT_NE(printed.find("# default\n"), std::string::npos);
  EXPECT_NE(printed.find("# CULLD_DATA\n"), std::string::npos);
  const auto again = configOf(printed);
  ASSERT_TRUE(again.ok()) << again.error().message << "\n" << printed;
  for (const ConfigKey& key : configKeys()) {
    EXPECT_EQ(key.get(again.value()), key.get(config.value())) << key.name;
  }
  EXPECT_EQ(again.value().scenes, config.value().scenes);
}

TEST(Config, SaysWhichChangesWaitForAStart) {
  const auto before = configOf("threads = 1\n[log]\nlevel = \"info\"");
  const auto after = configOf("threads = 2\n[log]\nlevel = \"debug\"\n[scenes]\na = \"x\"");
  ASSERT_TRUE(before.ok() && after.ok());
  EXPECT_EQ(changedForRestart(before.value(), after.value()),
            (std::vector<std::string>{"threads", "scenes"}));
  EXPECT_TRUE(changedForRestart(after.value(), after.value()).empty());
}

TEST(Config, KeysHaveNamesVariablesAndFlagsOfTheirOwn) {
  std::set<std::string> names;
  for (const ConfigKey& key : configKeys()) {
    EXPECT_TRUE(names.insert(key.name).second) << key.name;
    EXPECT_TRUE(names.insert(key.variable()).second) << key.variable();
    EXPECT_TRUE(key.flag.empty() || names.insert(key.flag).second) << key.flag;
    EXPECT_EQ(findKey(key.name), &key);
  }
}

std::string documentedRow(const ConfigKey& key) {
  const ConfigValue value = key.get(Config());
  const auto* text = std::get_if<std::string>(&value);
  const std::string given = text && text->empty() ? "" : "`" + toToml(value) + "`";
  return "| `" + key.name + "` | " + given + " | " +
         (key.range.empty() ? std::string(nameOf(key.kind)) : key.range) + " | `" + key.variable() +
         "` | " + (key.flag.empty() ? "" : "`" + key.flag + "`") + " | " +
         (key.reloaded ? "yes" : "") + " | " + key.what + " |";
}

TEST(Config, IsDocumentedKeyByKey) {
  std::ifstream file(CULLD_DOCS "/configuration.md");
  std::vector<std::string> documented;
  for (std::string line; std::getline(file, line);) {
    if (line.find("| `CULLD_") != std::string::npos) documented.push_back(line);
  }
  std::vector<std::string> expected;
  std::string table;
  for (const ConfigKey& key : configKeys()) {
    expected.push_back(documentedRow(key));
    table += expected.back() + "\n";
  }
  EXPECT_EQ(documented, expected) << "docs/configuration.md should hold\n" << table;
}

}  // namespace
}  // namespace culld::server
