// SPDX-License-Identifier: Apache-2.0
// protocol plan: what a protocol will do, without instruments.
#include <fmt/ostream.h>

#include <nlohmann/json.hpp>

#include "daemon/rehearse.hpp"
#include "daemon/rig/bench.hpp"
#include "protocols/expand.hpp"
#include "protocols/file/parse.hpp"
#include "protocols/plan/plan.hpp"
#include "storage/runs.hpp"
#include "tools/lcrig/commands.hpp"
#include "tools/lcrig/library_path.hpp"
#include "tools/lcrig/plan_text.hpp"
#include "tools/lcrig/print_json.hpp"
#include "tools/lcrig/specimen_lookup.hpp"

namespace lcrig::cli {

namespace {

Failure refused(const Error& error, const std::string& protocol) {
  Failure out(error,
              fmt::format("lcrig protocol show {}   (its parameters: -p NAME=VALUE)", protocol));
  if (error.code == Errc::invalid_request) out.code = kProtocol;
  return out;
}

class PlanCommand final : public Command {
 public:
  const char* name() const override { return "protocol plan"; }
  const char* summary() const override { return "Steps, time, readings, forces, without moving"; }
  const char* example() const override { return "lcrig protocol plan dynamic-cycles -p cycles=20"; }
  void declare(ArgumentList& list) override {
    list.positional("PROTOCOL", protocol_, "Name or file");
    list.options("-p,--parameter", parameters_, "NAME=VALUE", "Change a parameter");
    list.option("-s,--specimen", specimen_, "S", "For better estimates: what will be pressed");
    list.option("--bench", bench_, "B", "Instruments and fixture (default: paper)");
  }
  Outcome<ExitCode> run(Context& context) override;

 private:
  Outcome<BenchRequest> bench_request(const Context& context, const LibraryPath& library) const;

  std::string protocol_, specimen_, bench_ = "paper";
  std::vector<std::string> parameters_;
};

Outcome<BenchRequest> PlanCommand::bench_request(const Context& context,
                                                 const LibraryPath& library) const {
  BenchRequest out;
  out.bench = bench_;
  if (!replay_directory(bench_)) {
    auto bench = library.find(LibraryKind::bench, bench_);
    if (!bench) return tl::unexpected(bench.error());
    if (*bench) out.bench_text = std::move((*bench)->text);
  }
  if (specimen_.empty()) return out;
  auto db = context.db_path();
  if (!db) return tl::unexpected(db.error());
  auto specimen = find_specimen_text(context, *db, specimen_);
  if (!specimen) return tl::unexpected(specimen.error());
  out.specimen_name = specimen->name;
  out.specimen_text = std::move(specimen->text);
  return out;
}

Outcome<ExitCode> PlanCommand::run(Context& context) {
  auto parameters = parse_assignments(parameters_);
  if (!parameters) return tl::unexpected(parameters.error());
  const LibraryPath library(context.env);
  auto file = library.get(LibraryKind::protocol, protocol_);
  if (!file) return tl::unexpected(file.error());
  auto protocol = parse_protocol(file->text, file->path.string());
  if (!protocol) return tl::unexpected(refused(protocol.error(), protocol_));
  auto bound = bind_parameters(*protocol, *parameters);
  if (!bound) return tl::unexpected(refused(bound.error(), protocol_));
  auto request = bench_request(context, library);
  if (!request) return tl::unexpected(request.error());
  request->weights = places_weights(protocol->steps);
  auto rig = context.daemon.bench_rig(*request);
  if (!rig) return tl::unexpected(Failure(rig.error(), "lcrig rehearse --help"));
  auto plan = make_plan(*protocol, *bound, *rig);
  if (!plan) return tl::unexpected(refused(plan.error(), protocol_));
  if (context.global.json) {
    print_json(context.console.out, to_json(*plan));
  } else {
    print_plan(context.console.out, to_json(*plan));
    fmt::print(context.console.err, "  next: lcrig rehearse {} --specimen paper-1\n", protocol_);
  }
  return kOk;
}

}  // namespace

std::unique_ptr<Command> make_protocol_plan_command() {
  return std::make_unique<PlanCommand>();
}

}  // namespace lcrig::cli
