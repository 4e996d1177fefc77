"""The file of a node's model: loaded at the start, saved and loaded by services."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from bha_interfaces.srv import LoadModel, SaveModel
from rclpy.node import Node

from bha_common.files import ModelFileError


class ModelRefusedError(ValueError):
    """A model that cannot be saved or used now; the message says why."""


class ModelFiles:
    """Offers `~/save_model` and `~/load_model`.

    Parameters
    ----------
    node : Who offers the services.
    path : Path used where a request names none; empty for no such path.
    write : Writes the node's model to a path; raises ModelRefusedError when there is none.
    read : Reads a model and takes it in use; raises ModelFileError or ModelRefusedError, and then
        the model in use stays.
    """

    def __init__(
        self, node: Node, path: str, write: Callable[[str], None], read: Callable[[str], None]
    ) -> None:
        self._node = node
        self._path = path
        self._write = write
        self._read = read
        node.create_service(SaveModel, "~/save_model", self._save)
        node.create_service(LoadModel, "~/load_model", self._load)

    def load_at_start(self) -> bool:
        """Load the model of an earlier run; whether there was one.

        Raises
        ------
        ModelFileError, ModelRefusedError
            When there is one that cannot be used: the node must not overwrite it.
        """
        if not self._path or not Path(self._path).expanduser().exists():
            return False
        self._read(self._path)
        self._node.get_logger().info(f"goes on with the model of {self._path}")
        return True

    def keep(self) -> None:
        """Write the model to its path, if it has one; a full disk must not end the node."""
        if not self._path:
            return
        try:
            self._write(self._path)
        except ModelRefusedError:
            pass  # nothing is there to be kept
        except OSError as error:
            self._node.get_logger().error(f"{self._path} cannot be written: {error.strerror}")

    def _save(self, request: SaveModel.Request, response: SaveModel.Response) -> SaveModel.Response:
        path = request.path or self._path
        try:
            self._write(_needed(path))
            response.success, response.message = True, path
        except ModelRefusedError as error:
            response.message = str(error)
        except OSError as error:
            response.message = f"{path} cannot be written: {error.strerror}"
        return response

    def _load(self, request: LoadModel.Request, response: LoadModel.Response) -> LoadModel.Response:
        path = request.path or self._path
        try:
            self._read(_needed(path))
            response.success, response.message = True, f"loaded {path}"
        except (ModelFileError, ModelRefusedError) as error:
            response.message = f"refused, the model in use stays: {error}"
        return response


def _needed(path: str) -> str:
    if not path:
        raise ModelRefusedError("give a path, or set the parameter model_file")
    return path
