"""`gen-art studio`: a page in the browser in which a preset is seen while it is changed."""

import click

from gen_art.commands.terminal import echo
from gen_art.errors import OutputError, UsageError

__all__ = ["command"]


@click.command("studio")
@click.argument("preset", default="fire")
@click.option("--port", type=click.IntRange(0, 65535), default=0, show_default=True, help="0 takes a free port.")
@click.option("--no-browser", is_flag=True, help="Print the address and open nothing.")
@click.option(
    "--plugin", "plugins", multiple=True, metavar="FILE.py", help="Load forces and emitters from a Python file."
)
@click.option("--precision", type=click.Choice(["f32", "f64"]), default="f32", show_default=True, help="Float type.")
@click.option("--threads", type=click.IntRange(1, 1024), help="Number of threads.")
def command(preset, port, no_browser, plugins, precision, threads):
    """Show PRESET in a page of the browser while it is changed: sliders for its knobs, its YAML, its film.

    The address is printed, with a token, and works on this machine alone. A PRESET or plugin that is saved elsewhere is read
    again. Ctrl+C ends it.
    """
    from gen_art.output.extras import check_installed
    from gen_art.output.live_plugins import LivePlugins

    live = LivePlugins(plugins)
    live.load()
    check_installed("the studio", "starlette", "uvicorn", "websockets", "watchfiles")
    from gen_art.studio.document import Document
    from gen_art.studio.server import Studio, listening_socket, serve

    if preset == "-":
        raise UsageError("the studio opens a name or a file, not standard input")
    document = Document(preset)
    try:
        found = listening_socket(port)
    except OSError as error:
        raise OutputError(f"port {port}: {error.strerror or error}; --port 0 takes a free one") from None
    studio = Studio(document, live, precision, threads)
    address = f"http://127.0.0.1:{found.getsockname()[1]}/?token={studio.token}"
    echo(address)
    if not no_browser:
        _open(address)
    serve(studio, found)


def _open(address: str) -> None:
    import webbrowser

    if not webbrowser.open(address):
        echo("gen-art: no browser could be opened; open the address above in one", err=True)
