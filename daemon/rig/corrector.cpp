// SPDX-License-Identifier: Apache-2.0
#include "daemon/rig/corrector.hpp"

#include <spdlog/spdlog.h>

#include "base/aside.hpp"
#include "base/clock.hpp"
#include "base/text.hpp"
#include "daemon/control/audit.hpp"
#include "daemon/record/room.hpp"
#include "daemon/rig/instruments.hpp"
#include "daemon/rig/known.hpp"
#include "storage/database.hpp"

namespace lcrig {

namespace {

// Slow readings, because a correction is as noisy as the readings that it is made of.
LcrSettings quiet_settings() {
  LcrSettings out;
  out.aperture = Aperture::slow;
  return out;
}

}  // namespace

std::string meter_name(const Identity& identity) {
  return identity.serial.empty() ? identity.text : identity.model + " " + identity.serial;
}

MeterCorrections corrections_of(const Identity& identity, bool simulated, const CorrectionsOn& on) {
  MeterCorrections out;
  out.meter = meter_name(identity);
  out.simulated = simulated;
  out.open.on = on.open;
  out.short_circuit.on = on.short_circuit;
  return out;
}

void Corrector::give_up() {
  given_up_ = true;
  if (in_use_ != nullptr) in_use_->close();
}

Task<Result<Identity>> Corrector::identify(LcrMeter& meter) {
  auto identity = co_await meter.identify();
  parts_.known.learned(Instrument::lcr, identity, Learned(LearnedBy::look));
  if (identity) identity_ = identity->text;
  co_return identity;
}

Task<Result<MeterCorrections>> Corrector::use(LcrMeter& meter, std::optional<CorrectionKind> kind) {
  auto identity = co_await identify(meter);
  if (!identity) co_return fail(identity.error());
  if (kind) {
    auto made = co_await correct(meter, *kind);
    if (!made) co_return fail(made.error());
  }
  auto on = co_await meter.corrections();
  if (!on) co_return fail(on.error());
  auto safe = co_await meter.make_safe();
  if (!safe) co_return fail(safe.error());
  co_return corrections_of(*identity, identity->simulated, *on);
}

Task<Result<MeterCorrections>> Corrector::with_meter(std::optional<CorrectionKind> kind) {
  auto opened = co_await parts_.rig.open_lone_meter();
  if (!opened && opened.error().code != Errc::unsupported) {
    parts_.known.failed(Instrument::lcr, opened.error(), Learned(LearnedBy::look));
  }
  if (!opened) co_return fail(opened.error());
  in_use_ = &(*opened)->meter();
  if (given_up_) in_use_->close();
  auto out = co_await use(*in_use_, kind);
  in_use_ = nullptr;
  co_await (*opened)->close();
  if (!out && given_up_) {
    co_return fail(Errc::aborted, "the daemon is stopping; the meter may go on by itself");
  }
  co_return out;
}

Task<Result<>> Corrector::correct(LcrMeter& meter, CorrectionKind kind) {
  const LcrSettings settings = quiet_settings();
  auto configured = co_await meter.configure(settings);
  if (!configured) co_return fail(configured.error());
  auto made = co_await meter.correct(kind);
  // A meter with a verdict is idle, and a person may use its keys.
  if (!made && made.error().code == Errc::refused) {
    auto safe = co_await meter.make_safe();
    if (!safe) spdlog::warn("{}", printable(safe.error().what));
  }
  co_return made;
}

Task<Result<MeterCorrections>> Corrector::correct_if_room(CorrectionKind kind) {
  const auto look = [this] { return require_room(parts_.database, parts_.bytes); };
  auto room = co_await run_aside(parts_.executor, parts_.clock, look);
  if (!room) co_return fail(room.error());
  auto meter = co_await with_meter(kind);
  co_return meter;
}

Task<Result<MeterCorrections>> Corrector::make(CorrectionKind kind, PeerCredentials peer) {
  auto meter = co_await correct_if_room(kind);
  const auto words = fmt::format("the {} correction, for {}", to_string(kind), peer_words(peer));
  if (!meter) {
    spdlog::warn("{}: {}", words, printable(meter.error().what));
    co_return meter;
  }
  StoredCorrection made;
  made.kind = kind;
  made.meter = meter->meter;
  made.lcr_identity = identity_;
  made.simulated = meter->simulated;
  made.operator_name = peer.user;
  made.operator_uid = peer.uid;
  made.made_unix_ns = parts_.clock.unix_ns();
  const auto store = [this, &made, &meter]() -> Result<> {
    auto db = open_read_write(parts_.database, parts_.vfs);
    if (!db) return fail(db.error());
    if (auto stored = add_correction(*db, made); !stored) return stored;
    return look_up_corrections(*db, *meter);
  };
  auto stored = co_await run_aside(parts_.executor, parts_.clock, store);
  if (!stored) {
    co_return fail(stored.error().code, "the {} correction is on at the meter, but not stored: {}",
                   to_string(kind), stored.error().what);
  }
  spdlog::info("{}: made with {}", words, printable(meter->meter));
  co_return meter;
}

Task<Result<MeterCorrections>> Corrector::look() {
  auto meter = co_await with_meter(std::nullopt);
  if (!meter) co_return meter;
  const auto find = [this, &meter]() -> Result<> {
    auto db = open_read_only(parts_.database, parts_.vfs);
    if (!db) return fail(db.error());
    return look_up_corrections(*db, *meter);
  };
  auto found = co_await run_aside(parts_.executor, parts_.clock, find);
  if (!found) co_return fail(found.error());
  co_return meter;
}

}  // namespace lcrig
