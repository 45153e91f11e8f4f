<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>
<qgis version="3.22" styleCategories="Symbology|Labeling" labelsEnabled="1">
  <renderer-v2 type="singleSymbol">
    <symbols>
      <symbol type="marker" name="0">
        <layer class="SimpleMarker">
          <prop k="name" v="circle"/>
          <prop k="size" v="2.6"/>
          <prop k="color" v="240,228,66,255"/>
          <prop k="outline_color" v="29,36,43,255"/>
          <prop k="outline_width" v="0.4"/>
        </layer>
      </symbol>
    </symbols>
  </renderer-v2>
  <labeling type="simple">
    <settings>
      <text-style fieldName="name" fontSize="9" fontSizeUnit="Point" textColor="29,36,43,255">
        <text-buffer bufferDraw="1" bufferSize="0.8" bufferColor="255,255,255,220"/>
      </text-style>
      <placement placement="6" dist="1"/>
    </settings>
  </labeling>
  <layerGeometryType>0</layerGeometryType>
</qgis>
