// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/gateway.hpp"

#include <csignal>
#include <fstream>
#include <iostream>

namespace lcrig::e2e {

const std::vector<std::string> kForeign{"stiffness_N_mm=120",      "stiffness_curvature_per_mm=0",
                                        "stiffness_most_N_mm=200", "contact_travel_mm=30",
                                        "start_travel_mm=29.6",    "device_reaction_s=0.008",
                                        "cell_offset_N=0.02"};

void Gateway::start_rig(const std::vector<std::string>& machine,
                        const std::vector<std::string>& options) {
  start_sim({"--weights"});
  std::vector<std::string> command{"tools/gateway/lcrig-gateway",
                                   "--port",
                                   "0",
                                   "--panel-port",
                                   "0",
                                   "--truth",
                                   file("truth.jsonl")};
  for (const std::string& set : machine) command.insert(command.end(), {"--set", set});
  command.insert(command.end(), options.begin(), options.end());
  gateway_ = std::make_unique<Child>(command, file("gateway.log"));
  const auto line = gateway_->out().next(20s);
  ASSERT_TRUE(line) << "the gateway does not start: " << gateway_->log();
  ready_ = json::parse(*line);
  ports_["frame"] = ready_.at("frame");
}

void Gateway::TearDown() {
  for (auto& daemon : daemons_) daemon->signal(SIGTERM);
  for (auto& daemon : daemons_) daemon->wait(20s);
  if (gateway_) end_gateway();
  if (HasFailure() && gateway_) std::cerr << "--- gateway\n" << gateway_->log();
  Rig::TearDown();
}

json Gateway::end_gateway() {
  gateway_->signal(SIGTERM);
  EXPECT_EQ(gateway_->wait(10s), 0) << gateway_->log();
  json last;
  for (const json& line : truth()) last = line;
  EXPECT_EQ(last.value("event", ""), "summary");
  return last;
}

std::vector<json> Gateway::truth() const {
  std::vector<json> out;
  std::ifstream in(file("truth.jsonl"));
  for (std::string line; std::getline(in, line);) {
    json one = json::parse(line, nullptr, false);
    if (one.is_object()) out.push_back(std::move(one));
  }
  return out;
}

json Gateway::foreign_config(std::optional<double> stiffness_N_mm) const {
  json c = config();
  c["frame"] = {{"driver", "zwick"}, {"port", ports_.at("frame")}};
  if (stiffness_N_mm) c["frame"]["stiffness_N_mm"] = *stiffness_N_mm;
  return c;
}

std::string Gateway::panel(const std::string& order) const {
  const std::string at = ready_.at("panel").get<std::string>();
  const auto colon = at.rfind(':');
  const std::string host =
      at.substr(0, colon).substr(at.find("//") == at.npos ? 0 : at.find("//") + 2);
  std::vector<std::string> command{"/usr/bin/python3",
                                   "-c",
                                   "import socket,sys\n"
                                   "s=socket.create_connection((sys.argv[1],int(sys.argv[2])),5)\n"
                                   "s.sendall((sys.argv[3]+'\\n').encode())\n"
                                   "print(s.makefile().readline().strip())",
                                   host,
                                   at.substr(colon + 1),
                                   order};
  Child child(command, file("panel.log"));
  return child.out().rest(10s);
}

std::string foreign_protocol(const std::string& contact_mm_s, const std::string& load_mm_s) {
  return R"({ "format": "load-protocol/1", "name": "foreign",
  "limits": { "force_N": [-0.2, 1.5], "gap_mm": [-1, 25] },
  "sample": { "lcr": { "function": "Cp-D", "frequency_Hz": 1000, "level_V": 1.0, "aperture": "fast",
      "trigger": "internal" }, "frame": { "rate_Hz": 100 } },
  "steps": [
    { "id": "zero", "do": "zero", "force": true, "max_offset_N": 0.5 },
    { "id": "contact", "do": "find_contact", "speed_mm_s": )" +
         contact_mm_s + R"(, "force_N": 0.02, "back_off_mm": 0.05, "timeout_s": 60 },
    { "id": "load", "do": "move_until", "until": { "force_N": 0.8 }, "speed_mm_s": )" +
         load_mm_s + R"(, "timeout_s": 60 },
    { "id": "stay", "do": "hold", "hold": "travel", "for_s": 3 },
    { "id": "unload", "do": "ramp", "to": { "gap_mm": 0.2 }, "speed_mm_s": 0.5, "timeout_s": 20 } ],
  "finally": [ { "id": "clear", "do": "ramp", "to": { "gap_mm": 1 }, "speed_mm_s": 0.5, "timeout_s": 20 } ] })";
}

}  // namespace lcrig::e2e
