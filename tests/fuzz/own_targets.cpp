#include <ecorche/authoring/attachments.h>
#include <ecorche/domain/domain_cache.h>
#include <ecorche/domain/tet_files.h>
#include <ecorche/exchange/medit.h>
#include <ecorche/exchange/model_record.h>
#include <ecorche/exchange/report.h>
#include <ecorche/exchange/vtu.h>

#include <string>

#include "fuzz/targets.h"

namespace ecorche::test {

namespace {

template <class Indices>
bool within(const Indices& indices, Eigen::Index count) {
  return indices.size() == 0 || (indices.minCoeff() >= 0 && indices.maxCoeff() < count);
}

template <class T>
bool refused(const Result<T>& result, bool withFile = true) {
  if (result) return false;
  demand(!result.error().message.empty(), "an error without a sentence");
  demand(!withFile || result.error().place.file == "fuzz", "an error without a place");
  return true;
}

// What ecorche-worker sends back
void answer(std::string_view bytes) {
  const auto read = domain::decodeTetAnswer(bytes);
  if (refused(read, false)) return;
  demand(within(read->T, read->V.rows()) && within(read->F, read->V.rows()), "wrong corners");
  demand(read->tag.size() == static_cast<std::size_t>(read->F.rows()), "faces without a tag");
  demand(domain::encodeTetAnswer(*read) == bytes, "an answer that is not written as it was read");
}

// What ecorche-worker is sent
void request(std::string_view bytes) {
  const auto tets = domain::decodeTetRequest(bytes);
  if (!refused(tets, false))
    demand(within(tets->surface.F, tets->surface.V.rows()), "wrong corners");
  const auto fill = domain::decodeFillRequest(bytes);
  if (refused(fill, false)) return;
  demand(within(fill->surface.F, fill->surface.V.rows()), "wrong corners");
  demand(domain::encodeFillRequest(*fill) == bytes, "a request that is not written as it was read");
  const mesh::Box box = fill->sizing.box();
  for (const mesh::Vector3& at : {box.lo, box.hi, mesh::Vector3(-1e300, 0.0, 1e300)})
    (void)fill->sizing.at(at);
}

// As it stands, and as if its checksum were right
void cache(std::string_view bytes) {
  for (const std::string& file : {std::string(bytes), domain::sealed(bytes)}) {
    const auto build = domain::decodeCached(file);
    if (!build) continue;
    const domain::Domain& d = build->domain;
    const auto faces = static_cast<std::size_t>(d.boundaryF.rows());
    demand(within(d.mesh.T, d.mesh.V.rows()), "wrong corners of tets");
    demand(within(d.boundaryF, d.mesh.V.rows()), "wrong corners of faces");
    demand(d.neighbours.rows() == d.mesh.T.rows(), "tets without neighbours");
    demand(d.boundaryTet.size() == faces && d.boundaryTag.size() == faces, "faces without a tag");
    demand(d.onSkin.size() == static_cast<std::size_t>(d.mesh.V.rows()), "vertices of no kind");
    (void)d.freeVertexCount();
  }
}

template <Result<exchange::AnatomyFile> (*parse)(std::string_view, const std::string&)>
void anatomy(std::string_view bytes) {
  const auto read = parse(bytes, "fuzz");
  if (refused(read)) return;
  const auto vertices = read->mesh.V.rows();
  const auto tets = static_cast<std::size_t>(read->mesh.T.rows());
  demand(within(read->mesh.T, vertices) && within(read->F, vertices), "wrong corners");
  demand(read->tissue.size() == tets, "tets without a tissue");
  demand(read->reference.size() == static_cast<std::size_t>(read->F.rows()), "faces of no kind");
  demand(read->tendon.empty() || read->tendon.size() == tets, "tendon of other tets");
  demand(read->tetFiber.rows() == 0 || read->tetFiber.rows() == read->mesh.T.rows(),
         "fibres of other tets");
  demand(read->vertexFiber.rows() == 0 || read->vertexFiber.rows() == vertices,
         "fibres of other vertices");
}

void model(std::string_view bytes) {
  const auto record = exchange::parseModelRecord(bytes, "fuzz");
  if (refused(record)) return;
  const std::string text = exchange::printModelRecord(*record);
  const auto again = exchange::parseModelRecord(text, "fuzz");
  demand(again && exchange::printModelRecord(*again) == text,
         "a record that its own text does not give back");
}

void report(std::string_view bytes) {
  const auto read = exchange::parseReport(std::string(bytes), "fuzz");
  if (refused(read)) return;
  (void)exchange::reportTable(*read);
  const std::string text = exchange::printReport(*read);
  const auto again = exchange::parseReport(text, "fuzz");
  demand(again && exchange::printReport(*again) == text,
         "a report that its own text does not give back");
}

void attachments(std::string_view bytes) {
  const auto muscles = authoring::parseAttachments(bytes, "fuzz", 1.0);
  if (refused(muscles)) return;
  for (const authoring::MuscleSites& muscle : *muscles) {
    demand(!muscle.muscle.empty() && !muscle.sites.empty(), "a muscle without name or sites");
    for (const authoring::AttachmentSite& site : muscle.sites)
      demand(site.at.allFinite() && site.line > 1, "a site that is nowhere");
  }
}

constexpr FuzzTarget kOwnTargets[] = {
    {"answer", answer},   {"attachments", attachments},
    {"cache", cache},     {"medit", anatomy<exchange::parseMedit>},
    {"model", model},     {"report", report},
    {"request", request}, {"vtu", anatomy<exchange::parseVtu>},
};

}  // namespace

std::span<const FuzzTarget> ownTargets() { return kOwnTargets; }

}  // namespace ecorche::test
