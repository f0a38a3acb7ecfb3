// SPDX-License-Identifier: Apache-2.0
#include "analysis/export.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "analysis/export_context.hpp"
#include "analysis/pressure_of_run.hpp"
#include "base/iso_time.hpp"
#include "base/text.hpp"
#include "base/whole_file.hpp"

namespace lcrig {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::array<Layout, 6> kLayouts{Layout::readings, Layout::frame,   Layout::levels,
                                         Layout::events,   Layout::aligned, Layout::answers};
constexpr const char* kPackage = "datapackage.json";

// Identifies the run among all runs, including those of other databases.
json identity_of(const ExportContext& c) {
  return {{"run", c.id},
          {"started_unix_ns", c.run.started_unix_ns},
          {"started_mono_ns", c.start_ns},
          {"protocol", c.run.protocol_name},
          {"specimen", c.run.specimen_name}};
}

bool holds_same_run(const fs::path& folder, const ExportContext& c) {
  std::ifstream file(folder / kPackage);
  const json j = json::parse(file, nullptr, false);
  return j.is_object() && j.contains("lcrig") && j["lcrig"].is_object() &&
         j["lcrig"].value("identity", json()) == identity_of(c);
}

Result<> prepare_folder(const fs::path& folder, const ExportContext& c, bool force) {
  std::error_code ec;
  fs::create_directories(folder, ec);
  if (ec) return fail(Errc::io, "{}: {}; give another -o", folder.string(), ec.message());
  const bool empty = fs::is_empty(folder, ec);
  if (ec) return fail(Errc::io, "{}: {}; give another -o", folder.string(), ec.message());
  if (empty || force || holds_same_run(folder, c)) return {};
  return fail(Errc::invalid_request,
              "{}: holds other files; give an empty folder, or --force to replace {}, frame.csv, "
              "levels.csv, events.csv, aligned.csv, answers.csv and {}",
              folder.string(), file_name(Layout::readings), kPackage);
}

json fields_of(const ExportContext& c, Layout layout) {
  json fields = json::array();
  for (const Column& column : columns_of(c, layout)) {
    json field = {
        {"name", column.name}, {"type", column.type}, {"description", column.description}};
    if (!column.unit.empty()) field["unit"] = column.unit;
    fields.push_back(std::move(field));
  }
  return fields;
}

json resource_of(const ExportContext& c, Layout layout) {
  return {{"name", to_string(layout)},
          {"path", file_name(layout)},
          {"profile", "tabular-data-resource"},
          {"format", "csv"},
          {"mediatype", "text/csv"},
          {"encoding", "utf-8"},
          {"dialect", {{"delimiter", ","}, {"lineTerminator", "\r\n"}, {"header", true}}},
          {"schema", {{"fields", fields_of(c, layout)}, {"missingValues", json::array({""})}}}};
}

json json_or_text(const std::string& text) {
  json j = json::parse(text, nullptr, false);
  return j.is_discarded() ? json(text) : j;
}

// Describes how the times of frame.csv were derived from the frame's own clock.
json clock_of(const ExportContext& c) {
  json pieces = json::array();
  for (const DeviceClock::Piece& p : c.clock.pieces()) {
    json j = {{"from_s", static_cast<double>(p.from_ns - c.start_ns) * 1e-9},
              {"times_of", p.known ? "device clock" : "arrival"}};
    if (p.known) {
      j["offset_s"] = static_cast<double>(p.offset_ns - c.start_ns) * 1e-9;
      j["rate_ppm"] = p.rate * 1e6;
      j["residual_s"] = p.residual_s;
    }
    pieces.push_back(std::move(j));
  }
  return pieces;
}

// Describes which readings were taken between two equal read-backs of the meter's settings. `null`
// as an end: everything before or after.
json proof_of(const ExportContext& c) {
  const auto seconds = [&c](std::int64_t mono_ns) {
    if (mono_ns == INT64_MIN || mono_ns == INT64_MAX) return json(nullptr);
    return json(static_cast<double>(mono_ns - c.start_ns) * 1e-9);
  };
  json spans = json::array();
  for (const AskedSpan& span : c.proof.unproven()) {
    spans.push_back(
        {{"asked_from_s", seconds(span.from_mono_ns)}, {"asked_to_s", seconds(span.to_mono_ns)}});
  }
  return {{"known", c.proof.is_known()}, {"unproven", std::move(spans)}};
}

json chain_of(const ChainReport& chain) {
  const auto anchor = anchor_of(chain);
  return {{"intact", chain.intact},
          {"goes_on", chain.goes_on},
          {"anchor", anchor ? json(to_string(*anchor)) : json()},
          {"finding", chain.finding}};
}

json metadata_of(const ExportContext& c, const RunListing& listing) {
  const RunRow& r = c.run;
  json j = {{"identity", identity_of(c)},
            {"uuid", r.uuid.empty() ? json(nullptr) : json(r.uuid)},
            {"recorded_run", r.copied_from ? r.copied_from->run : c.id},
            {"tags", listing.tags},
            {"simulated", r.simulated},
            {"started", iso_time(r.started_unix_ns)},  // the instant at which t_s is 0
            {"made", iso_time(true_time_ns(r))},  // another one for a rehearsal
            {"ended", nullptr},
            {"parameters", json_or_text(r.parameters_json)},
            {"lcr_identity", r.lcr_identity},
            {"frame_identity", r.frame_identity},
            {"lcr_settings", json_or_text(r.lcr_settings_json)},
            {"frame_capabilities", json_or_text(r.frame_capabilities_json)},
            {"frame_limits", json_or_text(r.frame_limits_json)},
            {"correction", json_or_text(r.correction_json)},
            {"frame_clock", clock_of(c)},
            {"proof", proof_of(c)},
            {"bench", r.bench_name},
            {"software_version", r.software_version},
            {"operator", r.operator_name},
            {"note", r.note},
            {"protocol_text", r.protocol_text},
            {"specimen_text", r.specimen_text},
            {"exit_status", nullptr},  // null: the run went on, or was cut off
            {"reason", listing.reason}};
  if (listing.ended_unix_ns) j["ended"] = iso_time(*listing.ended_unix_ns);
  if (listing.exit_status) j["exit_status"] = to_string(*listing.exit_status);
  if (r.probe_diameter_m) j["probe_diameter_m"] = *r.probe_diameter_m;
  j["pressure"] = to_json(pressure_of_run(r));
  j["pressure"]["columns_on"] = to_string(PressureOn::probe);
  if (r.seed) j["seed"] = *r.seed;
  if (r.model_level) j["model_level"] = *r.model_level;
  if (r.model_error_json) j["model_error"] = json_or_text(*r.model_error_json);
  return j;
}

}  // namespace

Result<> check_license(std::string_view text) {
  const bool address = text.starts_with("https://") || text.starts_with("http://");
  const auto is_fit = [address](char c) {
    const bool word = std::isalnum(static_cast<unsigned char>(c)) != 0;
    return word || std::string_view("-._").find(c) != std::string_view::npos ||
           (address && c > ' ' && c < 0x7f);
  };
  if (!text.empty() && std::ranges::all_of(text, is_fit)) return {};
  return fail(Errc::invalid_request,
              "licence `{}`: expected a name without blanks, like CC-BY-4.0, or an address that "
              "begins with https://",
              printable(text, 60));
}

std::string_view file_name(Layout layout) {
  constexpr std::string_view kFiles[] = {"lcr.csv",    "frame.csv",   "levels.csv",
                                         "events.csv", "aligned.csv", "answers.csv"};
  return kFiles[static_cast<std::size_t>(layout)];
}

std::string data_package(const ExportContext& c, const RunListing& listing,
                         const std::string& license, const ChainReport* chain) {
  json resources = json::array();
  for (const Layout layout : kLayouts) resources.push_back(resource_of(c, layout));
  json j = {{"name", fmt::format("lcrig-run-{}", c.id)},
            {"title", fmt::format("{}run {}: {} on {}", c.run.simulated ? "SIMULATED " : "", c.id,
                                  c.run.protocol_name, c.run.specimen_name)},
            {"profile", "tabular-data-package"},
            {"resources", std::move(resources)},
            {"lcrig", metadata_of(c, listing)}};
  if (!license.empty()) {
    const char* key = license.find("://") == std::string::npos ? "name" : "path";
    j["licenses"] = json::array({json{{key, license}}});
  }
  if (chain != nullptr) j["lcrig"]["chain"] = chain_of(*chain);
  return j.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

Result<> export_layout(const Database& db, std::int64_t run, Layout layout, int fd,
                       const std::string& name) {
  auto snapshot = Transaction::begin_read(db);
  if (!snapshot) return fail(snapshot.error());
  auto context = load_context(db, run);
  if (!context) return fail(context.error());
  CsvWriter out(fd, name);
  return write_layout(db, *context, layout, out);
}

Result<ExportedRun> export_run(const Database& db, std::int64_t run, const ExportOptions& options) {
  auto checked = verify_aside(db, run);
  auto snapshot = Transaction::begin_read(db);
  if (!snapshot) return fail(snapshot.error());
  auto context = load_context(db, run);
  if (!context) return fail(context.error());
  auto listing = get_run_listing(db, run);
  if (!listing) return fail(listing.error());
  if (!options.license.empty()) {
    if (auto good = check_license(options.license); !good) return fail(good.error());
  }
  const fs::path folder(options.directory);
  if (auto r = prepare_folder(folder, *context, options.force); !r) return fail(r.error());
  ExportedRun out;
  const auto write = [&](std::string_view file, auto fill) -> Result<> {
    const std::string path = (folder / file).string();
    return write_whole_file(path, [&](int fd) {
      CsvWriter to(fd, path);
      return fill(to);
    });
  };
  const auto write_package = [&](const ChainReport* chain) {
    return write(kPackage, [&](CsvWriter& to) -> Result<> {
      to.word(data_package(*context, *listing, options.license, chain));
      return to.flush();
    });
  };
  // Written first, so that an export that was interrupted is recognised as ours.
  if (auto r = write_package(nullptr); !r) return fail(r.error());
  out.files.push_back((folder / kPackage).string());
  for (const Layout layout : kLayouts) {
    auto r = write(file_name(layout),
                   [&](CsvWriter& to) { return write_layout(db, *context, layout, to); });
    if (!r) return fail(r.error());
    out.files.push_back((folder / file_name(layout)).string());
  }
  if (auto r = keep(checked.get(), out.chain); !r) return fail(r.error());
  if (auto r = write_package(&out.chain); !r) return fail(r.error());
  return out;
}

}  // namespace lcrig
