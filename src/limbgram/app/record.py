"""Record: what is kept and signed: the sheets to print, the report of the capture, its accuracy."""

from typing import Literal

from fastapi import APIRouter, Response
from fastapi.responses import FileResponse

from limbgram.app.replies import PAGE_POLICY, PICTURE, missing
from limbgram.app.state import AppStateHere, CaseHere, WorkspaceHere
from limbgram.cases.shape_record import shape_record_of
from limbgram.report.html import html_of
from limbgram.report.pdf import pdf_of
from limbgram.report.record.layout import record_report

router = APIRouter(tags=["record"])


@router.get("/cases/{case_id}/record.pdf", response_class=Response, responses=PICTURE)
def record_pdf(app_state: AppStateHere, workspace: WorkspaceHere) -> Response:
    """The record, two sheets of A4."""
    record = shape_record_of(workspace, app_state.shape_cache.work(workspace))
    pdf = pdf_of(record_report(record.content, record.pictures))
    name = f'inline; filename="{workspace.case.case_id}-record.pdf"'
    return Response(pdf, media_type="application/pdf", headers={"content-disposition": name})


@router.get("/cases/{case_id}/record.html", response_class=Response)
def record_page(app_state: AppStateHere, workspace: WorkspaceHere) -> Response:
    """The same as one page."""
    record = shape_record_of(workspace, app_state.shape_cache.work(workspace))
    page = html_of(record_report(record.content, record.pictures))
    return Response(page, media_type="text/html; charset=utf-8", headers=PAGE_POLICY)


@router.get("/cases/{case_id}/report/{page}", response_class=FileResponse, responses=PICTURE)
def report_page(case: CaseHere, page: Literal["report", "accuracy"]) -> FileResponse:
    """What the capture's report, or its accuracy, says; a page by itself."""
    path = case.folder.page if page == "report" else case.folder.accuracy("html")
    if not path.is_file():
        raise missing("app.no_report")
    return FileResponse(path, media_type="text/html; charset=utf-8", headers=PAGE_POLICY)
