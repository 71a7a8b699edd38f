// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "app/version.hpp"
#include "linux/config/config.hpp"
#include "linux/scratch.hpp"

namespace flotilla::target {
namespace {

std::variant<Config, Ending> read(std::vector<const char*> options, bool by_root = false) {
  options.insert(options.begin(), "flotillad");
  return read_config(options, by_root);
}

Config good(const std::vector<const char*>& options) {
  const auto result = read(options);
  if (const auto* ending = std::get_if<Ending>(&result)) FAIL(ending->text);
  return std::get<Config>(result);
}

std::string mistake(const std::vector<const char*>& options) {
  const auto result = read(options);
  REQUIRE(std::holds_alternative<Ending>(result));
  const auto& ending = std::get<Ending>(result);
  CHECK(ending.status == 2);
  CHECK(ending.text.starts_with("flotillad: "));
  CHECK(ending.text.find('\n') == ending.text.size() - 1);
  return ending.text;
}

/// A boat.toml with the given text.
struct File {
  Scratch folder;
  std::string path = (folder / "boat.toml").string();
  explicit File(const std::string& text) { put(path, text); }

  Config good(std::vector<const char*> options = {}) const {
    options.insert(options.begin(), {"--config", path.c_str()});
    return target::good(options);
  }
  /// The error message after "flotillad: …/boat.toml".
  std::string mistake() const {
    const std::string text = target::mistake({"--config", path.c_str()});
    const std::string start = "flotillad: " + path;
    REQUIRE(text.starts_with(start));
    return text.substr(start.size());
  }
};

TEST_CASE("root is refused before any file is read, with the alternatives") {
  const auto result = read({"--config", "/nowhere.toml"}, true);
  REQUIRE(std::holds_alternative<Ending>(result));
  const auto& ending = std::get<Ending>(result);
  CHECK(ending.status == 2);
  CHECK(ending.text.starts_with("flotillad: does not run as root"));
  CHECK(ending.text.find("flotillad.service") != std::string::npos);
  CHECK(ending.text.find("nowhere") == std::string::npos);
  CHECK(std::get<Ending>(read({"--help"}, true)).status == 0);
}

TEST_CASE("a boat needs only one link in its configuration") {
  const Config config = good({"--mavlink", "udpin:0.0.0.0:14550"});
  CHECK(config.can == "socketcan:can0");
  CHECK(config.mavlink == std::vector<MavlinkLinkConfig>{{"udpin:0.0.0.0:14550", 0}});
  CHECK(config.param.empty());
  CHECK(config.state_dir == "/var/lib/flotilla");
  CHECK(config.log.empty());
  CHECK(config.stop == StopLine{});
  CHECK(config.priority == 0);
  CHECK_FALSE(config.lock_memory);
}

TEST_CASE("every key of the file is read") {
  const File file(R"(
can = "mcast:3"
mavlink = ["udpout:127.0.0.1:14550", "serial:/dev/ttyUSB0:57600,rate=3000"]
state-dir = "/tmp/state"
log = "/tmp/log"
stats = "/tmp/stats.json"
stop-gpio = "gpiochip0:17"
priority = 50
lock-memory = true
[param]
MAV_SYSID = 2
LAW_KX = 0.25
THR_PORT_DIR = -1
)");
  const Config config = file.good();
  CHECK(config.can == "mcast:3");
  CHECK(config.mavlink == std::vector<MavlinkLinkConfig>{{"udpout:127.0.0.1:14550", 0},
                                                         {"serial:/dev/ttyUSB0:57600", 3000}});
  CHECK(config.state_dir == "/tmp/state");
  CHECK(config.parameter_file() == "/tmp/state/parameters.txt");
  CHECK(config.log == "/tmp/log");
  CHECK(config.stats == "/tmp/stats.json");
  CHECK(config.stop == StopLine{"gpiochip0", 17});
  CHECK(config.priority == 50);
  CHECK(config.lock_memory);
  CHECK(config.param ==
        ParameterOverrides{{"LAW_KX", 0.25F}, {"MAV_SYSID", 2}, {"THR_PORT_DIR", -1}});
  app::Parameters parameters;
  apply(config.param, parameters);
  CHECK(parameters.MAV_SYSID == 2);
  CHECK(parameters.LAW_KX == 0.25F);
  CHECK(parameters.LAW_KPSI == app::Parameters{}.LAW_KPSI);
}

/// A ground station's parameter file with that text.
struct ParameterFile {
  Scratch folder;
  std::string path = (folder / "boat.param").string();
  explicit ParameterFile(const std::string& text) { put(path, text); }
};

TEST_CASE("a parameter file is read in the format of each ground station") {
  const char* link = "--mavlink=udpin:127.0.0.1:14550";
  const char* texts[] = {
      "# Otter\nLAW_KX,0.25\nTHR_ARM,0.395\n",                        // Mission Planner
      "LAW_KX           0.250000 # slow\r\nTHR_ARM  0.395\r\n",       // MAVProxy
      "\xEF\xBB\xBFLAW_KX,0.25\r\nTHR_ARM,0.395\r\nLAW_KX,0.25\r\n",  // edited on Windows
      "# v\n\n1\t1\tLAW_KX\t0.25\t9\n1\t1\tTHR_ARM\t0.395\t9",        // QGroundControl
  };
  for (const std::string text : texts) {
    CAPTURE(text);
    const ParameterFile list(text);
    CHECK(good({link, "--param-file", list.path.c_str()}).param ==
          ParameterOverrides{{"LAW_KX", 0.25F}, {"THR_ARM", 0.395F}});
  }
}

TEST_CASE("a hull's own files are read, and single parameters override them") {
  const std::string hull = std::string(FLOTILLA_SOURCE) + "/sil/hulls/otter.param";
  const File file("mavlink = [\"udpin:0.0.0.0:1\"]\nparam = {VES_M11 = 9, LAW_KX = 0.25}\n");
  const Config config = file.good({"--param", "VES_M22=7", "--param-file", hull.c_str()});
  CHECK(config.param.at("VES_M11") == 85.28F);
  CHECK(config.param.at("VES_M22") == 7.0F);
  CHECK(config.param.at("LAW_KX") == 0.25F);
  const ParameterOverrides columns =
      good({"--mavlink=udpin:0.0.0.0:1", "--param-file", (hull + "s").c_str()}).param;
  CHECK(columns == good({"--mavlink=udpin:0.0.0.0:1", "--param-file", hull.c_str()}).param);
}

TEST_CASE("a mistake in a parameter file is reported with its line") {
  const std::pair<const char*, const char*> cases[] = {
      {"LAW_KX,0.25\nLAW_K,1\n", ":2: unknown parameter \"LAW_K\""},
      {"LAW_KX,3\n", ":1: LAW_KX = 3 (allowed: numbers from 0 to 2 1/s)"},
      {"\nLAW_KX,much\n", ":2: LAW_KX = much"},
      {"LAW_KX,0.25\nTHR_ARM,0.395\nLAW_KX,0.3\n", ":3: LAW_KX has another value above"},
      {"LAW_KX\n", ":1: neither NAME,VALUE nor QGroundControl's five columns"},
      {"1\t1\tLAW_KX\t0.25\n", ":1: neither NAME,VALUE nor QGroundControl's five columns"},
  };
  for (const auto& [text, said] : cases) {
    CAPTURE(text);
    const ParameterFile list(text);
    const std::string told =
        mistake({"--mavlink=udpin:0.0.0.0:1", "--param-file", list.path.c_str()});
    CHECK(told.starts_with("flotillad: " + list.path + said));
  }
  CHECK(mistake({"--mavlink=udpin:0.0.0.0:1", "--param-file", "/nowhere.param"})
            .starts_with("flotillad: /nowhere.param: cannot be read: "));
}

TEST_CASE("the command line overrides the file: links as a whole list, parameters one by one") {
  const File file(R"(
can = "mcast:3"
mavlink = ["udpout:127.0.0.1:14550", "udpin:127.0.0.1:14551"]
log = "/tmp/log"
priority = 50
lock-memory = true
param = {MAV_SYSID = 2, LAW_KX = 0.25}
)");
  const Config config =
      file.good({"--can", "socketcan:vcan1", "--mavlink", "udpin:127.0.0.1:1,rate=0", "--param",
                 "LAW_KX=0.5", "--param=THR_ARM=1e0", "--state-dir", "here",
                 "--log=", "--priority=0", "--lock-memory=false"});
  CHECK(config.can == "socketcan:vcan1");
  CHECK(config.mavlink == std::vector<MavlinkLinkConfig>{{"udpin:127.0.0.1:1", 0}});
  CHECK(config.param == ParameterOverrides{{"LAW_KX", 0.5F}, {"MAV_SYSID", 2}, {"THR_ARM", 1}});
  CHECK(config.state_dir == "here");
  CHECK(config.log.empty());
  CHECK(config.priority == 0);
  CHECK_FALSE(config.lock_memory);
}

TEST_CASE("telemetry uses only part of a serial line's rate, unless the rate is given") {
  const Config config = good({"--mavlink", "serial:/dev/ttyUSB0:9600", "--mavlink",
                              "serial:/dev/ttyUSB1:115200,signing=off", "--mavlink",
                              "serial:/dev/ttyUSB2:9600,rate=0", "--mavlink", "udpin:14550"});
  REQUIRE(config.mavlink.size() == 4);
  CHECK(config.mavlink[0].bytes_per_s == 768);
  CHECK(config.mavlink[1].bytes_per_s == 9216);
  CHECK(config.mavlink[2].bytes_per_s == 0);
  CHECK(config.mavlink[3].bytes_per_s == 0);
}

TEST_CASE("several links on the command line keep their order") {
  const Config config = good({"--mavlink", "udpin:127.0.0.1:1", "--mavlink",
                              "udpout:127.0.0.1:2,rate=10", "--lock-memory"});
  CHECK(config.mavlink ==
        std::vector<MavlinkLinkConfig>{{"udpin:127.0.0.1:1", 0}, {"udpout:127.0.0.1:2", 10}});
  CHECK(config.lock_memory);
}

TEST_CASE("a link's signing policy follows its address, before or after its rate") {
  using enum app::SigningPolicy;
  const File file(R"(
signing-key = "/etc/flotilla/key"
mavlink = ["udpin:10.0.0.1:1,signing=required,rate=9", "udpin:10.0.0.1:2,rate=9,signing=off",
           "udpin:10.0.0.1:3,signing=accept", "udpin:10.0.0.1:4"]
)");
  const Config config = file.good();
  CHECK(config.signing_key == "/etc/flotilla/key");
  CHECK(config.signing_time_file() == config.state_dir / "signing_time.txt");
  CHECK(config.mavlink == std::vector<MavlinkLinkConfig>{{"udpin:10.0.0.1:1", 9, kRequired},
                                                         {"udpin:10.0.0.1:2", 9, kOff},
                                                         {"udpin:10.0.0.1:3", 0, kAccept},
                                                         {"udpin:10.0.0.1:4"}});
  CHECK(config.policy(config.mavlink[0]) == kRequired);
  CHECK(config.policy(config.mavlink[1]) == kOff);
  CHECK(config.policy(config.mavlink[2]) == kAccept);
  CHECK(config.policy(config.mavlink[3]) == kRequired);
}

TEST_CASE("without a key no link signs, and a policy that signs is refused") {
  const Config config =
      good({"--mavlink=udpin:10.0.0.1:1", "--mavlink=udpin:10.0.0.1:2,signing=off"});
  CHECK(config.mavlink.size() == 2);
  for (const auto& link : config.mavlink) CHECK(config.policy(link) == app::SigningPolicy::kOff);
  for (const std::string policy : {"accept", "required"}) {
    const std::string link = "--mavlink=udpin:10.0.0.1:1,signing=" + policy;
    CHECK(mistake({link.c_str()}) ==
          "flotillad: mavlink: signing on udpin:10.0.0.1:1 needs a signing-key\n");
    CHECK(good({link.c_str(), "--signing-key=key"}).signing_key == "key");
  }
  const File file("signing-key = \"key\"\nmavlink = [\"udpin:10.0.0.1:1,signing=required\"]\n");
  CHECK(mistake({"--config", file.path.c_str(), "--signing-key="}).find("needs a signing-key") !=
        std::string::npos);
}

TEST_CASE("the shipped example is a valid configuration") {
  const Config config = good({"--config", FLOTILLA_SOURCE "/firmware/linux/boat.toml"});
  CHECK(config.can == Config{}.can);
  CHECK(config.state_dir == Config{}.state_dir);
  CHECK(config.mavlink.size() == 1);
}

TEST_CASE("--help and --version print their text and end with status 0") {
  const auto help = std::get<Ending>(read({"--help"}));
  CHECK(help.status == 0);
  for (const char* word :
       {"--config", "--can", "--mavlink", "--param", "--param-file", "--state-dir", "--signing-key",
        "signing=POLICY", "--log", "--stop-gpio", "--priority", "--lock-memory", "--version",
        "socketcan:IF", "udpbcast:HOST:PORT", "rate=BYTES"}) {
    CAPTURE(word);
    CHECK(help.text.find(word) != std::string::npos);
  }
  const auto version = std::get<Ending>(read({"--version"}));
  CHECK(version.status == 0);
  CHECK(version.text == "flotillad 0.1 (" + std::string(flotilla::app::source_revision()) + ")\n");
}

TEST_CASE("a mistake in the file names its line, its key and what is allowed") {
  struct {
    const char* text;
    const char* says;
  } const cases[] = {
      {"can = \"mcast:0\"\nspeed = 3\n",
       ":2:1: unknown key \"speed\" (allowed: can, mavlink, state-dir, signing-key, log, stats, "
       "stop-gpio, priority, lock-memory, param)\n"},
      {"can = 0\n", ":1:7: can: must be a string\n"},
      {"can = \"can0\"\n", ":1:7: can: \"can0\" is not a CAN bus (allowed: socketcan:, mcast:…)\n"},
      {"can = \"mcast:12\"\n",
       ":1:7: can: CAN bus \"mcast:12\": \"12\" is not a bus number from 0 to 9\n"},
      {"mavlink = [\"udpin:boat2.local:14550\"]\n",
       ":1:12: mavlink: MAVLink link \"udpin:boat2.local:14550\": \"boat2.local\" is not a numeric "
       "IPv4 address\n"},
      {"mavlink = [\"udpin:99999\"]\n",
       ":1:12: mavlink: MAVLink link \"udpin:99999\": \"99999\" is not a number from 1 to 65535\n"},
      {"mavlink = [\"serial:/dev/ttyACM0:115201\"]\n",
       ":1:12: mavlink: MAVLink link \"serial:/dev/ttyACM0:115201\": 115201 is not a supported "
       "baud "
       "rate\n"},
      {"can = \"socketcan:\"\n",
       ":1:7: can: \"socketcan:\" is not a CAN bus (allowed: socketcan:, mcast:…)\n"},
      {"mavlink = \"udpin:0.0.0.0:1\"\n",
       ":1:11: mavlink: must be a list of strings, such as [\"udpin:0.0.0.0:14550\"]\n"},
      {"mavlink = [\n  \"udpin:0.0.0.0:1\",\n  7,\n]\n", ":3:3: mavlink: must be a string\n"},
      {"mavlink = [\"tcp:1.2.3.4:5\"]\n",
       ":1:12: mavlink: \"tcp:1.2.3.4:5\" is not a MAVLink link (allowed: udpin:, udpout:, "
       "udpbcast:, "
       "serial:…)\n"},
      {"mavlink = [\"udpin:0.0.0.0:1,rate=fast\"]\n",
       ":1:12: mavlink: \",rate=fast\" of udpin:0.0.0.0:1 is invalid (allowed: ,rate=BYTES with "
       "whole "
       "bytes per second, 0: no limit; ,signing=off, accept or required)\n"},
      {"mavlink = [\"udpin:0.0.0.0:1,rate=1,signing=yes\"]\n",
       ":1:12: mavlink: \",signing=yes\" of udpin:0.0.0.0:1 is invalid (allowed: ,rate=BYTES with "
       "whole "
       "bytes per second, 0: no limit; ,signing=off, accept or required)\n"},
      {"signing-key = 7\n", ":1:15: signing-key: must be a string\n"},
      {"mavlink = [\"udpin:10.0.0.1:1\", \"udpin:10.0.0.1:2\", \"udpin:10.0.0.1:3\", "
       "\"udpin:10.0.0.1:4\", \"udpin:10.0.0.1:5\"]\n",
       ":1:11: mavlink: 5 links (allowed: 1 to 4)\n"},
      {"stop-gpio = \"17\"\n", ":1:13: stop-gpio: \"17\" is not CHIP:LINE, such as gpiochip0:17\n"},
      {"priority = 100\n", ":1:12: priority: allowed: whole numbers from 0 (off) to 99\n"},
      {"priority = 1.5\n", ":1:12: priority: must be a whole number\n"},
      {"lock-memory = 1\n", ":1:15: lock-memory: must be true or false\n"},
      {"param = 1\n", ":1:9: param: must be a table: [param] and NAME = VALUE lines\n"},
      {"[param]\n\nLAW_K = 1\n",
       ":3:9: param: unknown parameter \"LAW_K\" (see "
       "firmware/docs/PARAMETERS.md)\n"},
      {"[param]\nLAW_KX = \"much\"\n", ":2:10: param: LAW_KX must be a number\n"},
      {"[param]\nLAW_KX = true\n", ":2:10: param: LAW_KX must be a number\n"},
      {"[param]\nLAW_KX = 3\n", ":2:10: param: LAW_KX = 3 (allowed: numbers from 0 to 2 1/s)\n"},
      {"[param]\nLAW_KX = nan\n",
       ":2:10: param: LAW_KX = nan (allowed: numbers from 0 to 2 1/s)\n"},
      {"[param]\nLAW_KX = 1e300\n",
       ":2:10: param: LAW_KX = 1e+300 (allowed: numbers from 0 to 2 1/s)\n"},
      {"[param]\nMAV_SYSID = 1.5\n",
       ":2:13: param: MAV_SYSID = 1.5 (allowed: whole numbers from 1 to 254)\n"},
      {"[param]\nTHR_PORT_DIR = 0\n", ":2:16: param: THR_PORT_DIR = 0 (allowed: -1 or 1)\n"},
  };
  for (const auto& c : cases) {
    CAPTURE(c.text);
    CHECK(File(c.text).mistake() == c.says);
  }
}

TEST_CASE("an invalid TOML file, or a missing one, is reported in one line too") {
  CHECK(File("can = \n").mistake().starts_with(":1:7: "));
  CHECK(File("can = \"a\"\ncan = \"b\"\n").mistake().starts_with(":2:"));
  CHECK(mistake({"--config", "/no/such/boat.toml"}).find("/no/such/boat.toml") !=
        std::string::npos);
  CHECK(mistake({"--config", "/tmp"}).find("/tmp") != std::string::npos);
}

TEST_CASE("a mistake on the command line names the option and what is allowed") {
  const char* const link = "--mavlink=udpin:127.0.0.1:1";
  CHECK(mistake({}) ==
        "flotillad: no MAVLink link: give --mavlink, or --config FILE with the key mavlink\n");
  CHECK(mistake({link, "--param", "LAW_KX"}) ==
        "flotillad: --param: \"LAW_KX\" is not NAME=VALUE\n");
  CHECK(mistake({link, "--param", "LAW_KX=3"}) ==
        "flotillad: --param: LAW_KX = 3 (allowed: numbers from 0 to 2 1/s)\n");
  CHECK(mistake({link, "--param", "LAW_KX=0.1x"}) ==
        "flotillad: --param: LAW_KX = 0.1x (allowed: numbers from 0 to 2 1/s)\n");
  CHECK(mistake({link, "--param", "SPEED=3"}) ==
        "flotillad: --param: unknown parameter \"SPEED\" (see "
        "firmware/docs/PARAMETERS.md)\n");
  CHECK(mistake({link, "--priority", "high"}) ==
        "flotillad: --priority: allowed: whole numbers from 0 (off) to 99\n");
  for (const std::string wrong : {"gpiochip0", "gpiochip0:", ":3", "/dev/gpiochip0:3", "a:-1"}) {
    CHECK(mistake({link, "--stop-gpio", wrong.c_str()}) ==
          "flotillad: --stop-gpio: \"" + wrong + "\" is not CHIP:LINE, such as gpiochip0:17\n");
  }
  CHECK(mistake({link, "--can", "vcan0"}) ==
        "flotillad: --can: \"vcan0\" is not a CAN bus (allowed: socketcan:, mcast:…)\n");
  CHECK(mistake({"--mavlink", "udp:1:1"}).find("--mavlink: \"udp:1:1\" is not a MAVLink link") !=
        std::string::npos);
  CHECK(mistake({link, "--state-dir", ""}) ==
        "flotillad: state-dir: must be the name of a directory\n");
  CHECK(mistake({link, "--speed", "3"}).find("--speed") != std::string::npos);
  CHECK(mistake({link, "surplus"}).find("surplus") != std::string::npos);
  CHECK(mistake({link, "--priority"}).find("--priority") != std::string::npos);
  CHECK(mistake({link, "--lock-memory=perhaps"}).find("perhaps") != std::string::npos);
  CHECK(mistake({link, "--priority", "1", "--priority", "2"}).find("--priority") !=
        std::string::npos);
}

}  // namespace
}  // namespace flotilla::target
